#pragma once

#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

namespace veridyn {

/// A scalar that records its own computation: run once over it, the recursions become straight-line
/// code for one arm, without terms that are zero or one and with common subexpressions shared.
///
/// It belongs to the TracedProgram that is open on this thread.
class Traced {
 public:
  Traced() : Traced(0.0) {}
  Traced(double constant);  // NOLINT: constants take part in arithmetic

  int node() const { return node_; }
  static Traced of_node(int node) {
    Traced out;
    out.node_ = node;
    return out;
  }

  Traced& operator+=(const Traced& other);
  Traced& operator-=(const Traced& other);

 private:
  int node_ = 0;
};

Traced operator+(const Traced& a, const Traced& b);
Traced operator-(const Traced& a, const Traced& b);
Traced operator*(const Traced& a, const Traced& b);
Traced operator/(const Traced& a, const Traced& b);
Traced operator-(const Traced& a);

/// Overload for the recursions, which compute both at once.
void sine_cosine(const Traced& x, Traced& sine, Traced& cosine);

/// Records all computations during its lifetime; one per thread at a time.
class TracedProgram {
 public:
  TracedProgram();
  ~TracedProgram();
  TracedProgram(const TracedProgram&) = delete;
  TracedProgram& operator=(const TracedProgram&) = delete;

  /// Declares an input with the name `name`.
  Traced input(const std::string& name);

  /// C statements that compute every (left-hand side, value), with temporaries of a type R; indented
  /// by two. Sine and cosine are called @sin and @cos.
  std::string statements(const std::vector<std::pair<std::string, Traced>>& results) const;

 private:
  friend class Traced;
  friend Traced operator+(const Traced&, const Traced&);
  friend Traced operator-(const Traced&, const Traced&);
  friend Traced operator*(const Traced&, const Traced&);
  friend Traced operator/(const Traced&, const Traced&);
  friend Traced operator-(const Traced&);
  friend void sine_cosine(const Traced&, Traced&, Traced&);

  enum class Kind { kConstant, kInput, kSum, kDifference, kProduct, kQuotient, kMinus, kSine, kCosine };
  struct Node {
    Kind kind;
    std::optional<int> a, b;  ///< operands
    double value = 0.0;
    std::string name;
  };

  static TracedProgram& open();
  int constant(double value);
  int node(Kind kind, int a, std::optional<int> b = {});
  bool has_value(int node, double value) const;
  Traced sum(int a, int b);
  Traced difference(int a, int b);
  Traced product(int a, int b);
  Traced negated(int a);
  std::string expression(int node, const std::vector<int>& uses, int around) const;

  std::vector<Node> nodes_;
  std::map<double, int> constants_;
  std::map<std::tuple<Kind, int, std::optional<int>>, int> known_;
  TracedProgram* before_ = nullptr;
};

}  // namespace veridyn
