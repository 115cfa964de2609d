#include "traced.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cassert>
#include <utility>

namespace veridyn {
namespace {

thread_local TracedProgram* opened = nullptr;

constexpr double kNothing = 1e-17;  // smaller entries of a rotation are rounding errors of cos(pi/2)
constexpr double kRounding = 1e-15;  // tolerance for an offset that is a quarter turn
constexpr size_t kLongest = 110;    // longest expression in one line, in characters

}  // namespace

TracedProgram::TracedProgram() : before_(std::exchange(opened, this)) {}

TracedProgram::~TracedProgram() {
  opened = before_;
}

TracedProgram& TracedProgram::open() {
  assert(opened != nullptr);
  return *opened;
}

Traced::Traced(double constant) : node_(TracedProgram::open().constant(constant)) {}

int TracedProgram::constant(double value) {
  if (std::abs(value) < kNothing) value = 0.0;
  const auto [at, fresh] = constants_.emplace(value, static_cast<int>(nodes_.size()));
  if (fresh) nodes_.push_back({Kind::kConstant, {}, {}, value, {}});
  return at->second;
}

Traced TracedProgram::input(const std::string& name) {
  nodes_.push_back({Kind::kInput, {}, {}, 0.0, name});
  return Traced::of_node(static_cast<int>(nodes_.size()) - 1);
}

int TracedProgram::node(Kind kind, int a, std::optional<int> b) {
  if ((kind == Kind::kSum || kind == Kind::kProduct) && *b < a) std::swap(a, *b);
  const auto [at, fresh] = known_.emplace(std::make_tuple(kind, a, b),
                                          static_cast<int>(nodes_.size()));
  if (fresh) nodes_.push_back({kind, a, b, 0.0, {}});
  return at->second;
}

bool TracedProgram::has_value(int node, double value) const {
  const Node& n = nodes_[node];
  return n.kind == Kind::kConstant && n.value == value;
}

Traced TracedProgram::sum(int a, int b) {
  const Node& x = nodes_[a];
  const Node& y = nodes_[b];
  if (has_value(a, 0.0)) return Traced::of_node(b);
  if (has_value(b, 0.0)) return Traced::of_node(a);
  if (x.kind == Kind::kConstant && y.kind == Kind::kConstant) return Traced(x.value + y.value);
  if (y.kind == Kind::kMinus) return difference(a, *y.a);
  if (x.kind == Kind::kMinus) return difference(b, *x.a);
  if (x.kind == Kind::kDifference && *x.b == b) return Traced::of_node(*x.a);
  if (y.kind == Kind::kDifference && *y.b == a) return Traced::of_node(*y.a);
  return Traced::of_node(node(Kind::kSum, a, b));
}

Traced TracedProgram::difference(int a, int b) {
  const Node& x = nodes_[a];
  const Node& y = nodes_[b];
  if (a == b) return Traced(0.0);
  if (has_value(b, 0.0)) return Traced::of_node(a);
  if (has_value(a, 0.0)) return negated(b);
  if (x.kind == Kind::kConstant && y.kind == Kind::kConstant) return Traced(x.value - y.value);
  if (y.kind == Kind::kMinus) return sum(a, *y.a);
  if (x.kind == Kind::kSum && *x.b == b) return Traced::of_node(*x.a);
  if (x.kind == Kind::kSum && *x.a == b) return Traced::of_node(*x.b);
  return Traced::of_node(node(Kind::kDifference, a, b));
}

Traced TracedProgram::product(int a, int b) {
  const Node x = nodes_[a];
  const Node y = nodes_[b];
  if (has_value(a, 0.0) || has_value(b, 0.0)) return Traced(0.0);
  if (has_value(a, 1.0)) return Traced::of_node(b);
  if (has_value(b, 1.0)) return Traced::of_node(a);
  if (has_value(a, -1.0)) return negated(b);
  if (has_value(b, -1.0)) return negated(a);
  if (x.kind == Kind::kConstant && y.kind == Kind::kConstant) return Traced(x.value * y.value);
  if (x.kind == Kind::kMinus && y.kind == Kind::kMinus) return product(*x.a, *y.a);
  if (x.kind == Kind::kMinus) return negated(product(*x.a, b).node());
  if (y.kind == Kind::kMinus) return negated(product(a, *y.a).node());
  return Traced::of_node(node(Kind::kProduct, a, b));
}

Traced TracedProgram::negated(int a) {
  const Node x = nodes_[a];
  if (x.kind == Kind::kConstant) return Traced(-x.value);
  if (x.kind == Kind::kMinus) return Traced::of_node(*x.a);
  if (x.kind == Kind::kDifference) return difference(*x.b, *x.a);
  return Traced::of_node(node(Kind::kMinus, a));
}

Traced operator+(const Traced& a, const Traced& b) {
  return TracedProgram::open().sum(a.node(), b.node());
}

Traced operator-(const Traced& a, const Traced& b) {
  return TracedProgram::open().difference(a.node(), b.node());
}

Traced operator*(const Traced& a, const Traced& b) {
  return TracedProgram::open().product(a.node(), b.node());
}

Traced operator/(const Traced& a, const Traced& b) {
  TracedProgram& program = TracedProgram::open();
  if (program.has_value(a.node(), 0.0)) return Traced(0.0);
  if (program.has_value(b.node(), 1.0)) return a;
  return Traced::of_node(program.node(TracedProgram::Kind::kQuotient, a.node(), b.node()));
}

Traced operator-(const Traced& a) {
  return TracedProgram::open().negated(a.node());
}

Traced& Traced::operator+=(const Traced& other) {
  return *this = *this + other;
}

Traced& Traced::operator-=(const Traced& other) {
  return *this = *this - other;
}

// Reuses one sine and one cosine for angles such as q, pi - q and q + pi/2 of several joints.
void sine_cosine(const Traced& x, Traced& sine, Traced& cosine) {
  using Kind = TracedProgram::Kind;
  TracedProgram& program = TracedProgram::open();
  int at = x.node();
  double side = 1.0, offset = 0.0;  // x = side * at + offset
  const auto value = [&](int node) { return program.nodes_[node].value; };
  const auto is_constant = [&](int node) {
    return program.nodes_[node].kind == Kind::kConstant;
  };
  for (int before = -1; before != at;) {
    before = at;
    const TracedProgram::Node& n = program.nodes_[at];
    if (n.kind == Kind::kMinus) {
      side = -side;
      at = *n.a;
    } else if ((n.kind == Kind::kSum || n.kind == Kind::kDifference) && is_constant(*n.a)) {
      offset += side * value(*n.a);
      side = n.kind == Kind::kSum ? side : -side;
      at = *n.b;
    } else if ((n.kind == Kind::kSum || n.kind == Kind::kDifference) && is_constant(*n.b)) {
      offset += (n.kind == Kind::kSum ? side : -side) * value(*n.b);
      at = *n.a;
    }
  }
  double quarters = std::round(offset / M_PI_2);
  if (std::abs(offset - quarters * M_PI_2) > kRounding * std::abs(quarters)) {
    at = x.node();
    side = 1.0;
    quarters = 0.0;
  }
  Traced s, c;
  if (is_constant(at)) {
    s = Traced(std::sin(value(at)));
    c = Traced(std::cos(value(at)));
  } else {
    s = Traced::of_node(program.node(Kind::kSine, at));
    c = Traced::of_node(program.node(Kind::kCosine, at));
  }
  if (side < 0.0) s = -s;
  for (quarters = std::remainder(quarters, 4.0); quarters != 0.0; quarters -= std::copysign(1.0, quarters)) {
    const Traced old = s;  // sin(x + pi/2) = cos x, cos(x + pi/2) = -sin x
    s = quarters > 0.0 ? c : -c;
    c = quarters > 0.0 ? -old : old;
  }
  sine = s;
  cosine = c;
}

// Writes a node as C. `around` is the precedence of the enclosing operator: 0 none, 1 a sum, 2 after a minus, 3
// a product, 4 a divisor.
std::string TracedProgram::expression(int at, const std::vector<int>& uses, int around) const {
  const Node& n = nodes_[at];
  const auto part = [&](int child, int tightness) {
    const Kind kind = nodes_[child].kind;
    const bool leaf = kind == Kind::kConstant || kind == Kind::kInput;
    if (!leaf && uses[child] != 1) return fmt::format("t{}", child);
    return expression(child, uses, tightness);
  };
  const auto enclosed = [](bool needed, const std::string& inner) {
    return needed ? "(" + inner + ")" : inner;
  };
  switch (n.kind) {
    case Kind::kConstant: {
      std::string digits = fmt::format("{}", n.value);
      if (digits.find_first_of(".e") == std::string::npos) digits += ".0";
      return n.value < 0.0 ? "(R)(" + digits + ")" : "(R)" + digits;
    }
    case Kind::kInput:
      return n.name;
    case Kind::kSum:
      return enclosed(around > 1, part(*n.a, 1) + " + " + part(*n.b, 1));
    case Kind::kDifference:
      return enclosed(around > 1, part(*n.a, 1) + " - " + part(*n.b, 2));
    case Kind::kProduct:
      return enclosed(around > 3, part(*n.a, 3) + " * " + part(*n.b, 3));
    case Kind::kQuotient:
      return enclosed(around > 2, part(*n.a, 3) + " / " + part(*n.b, 4));
    case Kind::kMinus:
      return enclosed(around > 0, "-" + part(*n.a, 3));
    case Kind::kSine:
      return "@sin(" + part(*n.a, 0) + ")";
    case Kind::kCosine:
      return "@cos(" + part(*n.a, 0) + ")";
  }
  return {};
}

std::string TracedProgram::statements(
    const std::vector<std::pair<std::string, Traced>>& results) const {
  // Counts the uses of each node; children precede their parents.
  std::vector<int> uses(nodes_.size(), 0);
  for (const auto& [name, value] : results) ++uses[value.node()];
  for (size_t k = nodes_.size(); k-- > 0;) {
    if (uses[k] == 0) continue;
    for (const std::optional<int>& child : {nodes_[k].a, nodes_[k].b}) {
      if (child) ++uses[*child];
    }
  }
  // A node that is used once is inlined, unless the expression becomes too long.
  std::string out;
  for (size_t k = 0; k < nodes_.size(); ++k) {
    const Node& n = nodes_[k];
    if (uses[k] == 0 || n.kind == Kind::kConstant || n.kind == Kind::kInput) continue;
    const bool function = n.kind == Kind::kSine || n.kind == Kind::kCosine;
    const std::string written = expression(static_cast<int>(k), uses, 0);
    if (uses[k] == 1 && written.size() <= kLongest && !function) continue;
    uses[k] = std::max(uses[k], 2);
    out += fmt::format("  const R t{} = {};\n", k, written);
  }
  for (const auto& [name, value] : results) {
    const Kind kind = nodes_[value.node()].kind;
    const bool leaf = kind == Kind::kConstant || kind == Kind::kInput;
    const bool named = !leaf && uses[value.node()] > 1;
    out += fmt::format("  {} = {};\n", name,
                       named ? fmt::format("t{}", value.node())
                             : expression(value.node(), uses, 0));
  }
  return out;
}

}  // namespace veridyn
