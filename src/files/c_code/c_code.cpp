#include "veridyn/files/c_code.hpp"

#include <fmt/format.h>

#include <cctype>
#include <set>
#include <utility>
#include <vector>

#include "traced.hpp"
#include "veridyn/dynamics/arm_dynamics.hpp"
#include "effects/written_in_c.hpp"
#include "files/output_file.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/model/joint_sensors.hpp"
#include "veridyn/effects/effect_facts.hpp"

namespace veridyn {
namespace {

constexpr int kMemory = 3;  // number of doubles in the memory of an effect

const char* const kSymbols[] = {"m", "hx", "hy", "hz", "Lxx", "Lxy", "Lyy", "Lxz", "Lyz", "Lzz"};

std::string c_identifier(const std::string& name) {
  std::string out;
  for (const char c : name) out += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
  if (out.empty() || std::isdigit(static_cast<unsigned char>(out.front())) != 0) out = "arm_" + out;
  return out;
}

// Removes characters that a C comment or string must not contain; two question marks begin a trigraph in C99.
std::string safe_c_text(std::string words) {
  for (char& c : words) {
    if (c == '*' || c == '\\' || c == '"' || c == '?' || (c >= 0 && c < ' ')) c = ' ';
  }
  return words;
}

// The linear form c . q + s0 as C.
std::string linear_form(const Axis& axis, const char* variable, double offset) {
  std::string out;
  for (Eigen::Index i = 0; i < axis.coefficients.size(); ++i) {
    const double c = axis.coefficients[i];
    if (c == 0.0) continue;
    if (!out.empty()) out += " + ";
    out += c == 1.0 ? fmt::format("{}[{}]", variable, i)
                    : fmt::format("{} * {}[{}]", c_number(c), variable, i);
  }
  if (offset != 0.0) out += (out.empty() ? "" : " + ") + c_number(offset);
  return out.empty() ? "0.0" : out;
}

class CWriter {
 public:
  explicit CWriter(const Model& arm) : arm_(arm), tree_(arm, Tree::Keep::kMovingLinks), name_(c_identifier(arm.name())) {
    const auto phi = arm.inertial_values();
    require(phi.has_value(), "export: arm '", arm.name(),
            "' has bodies without values, expected a MODEL that identify or diagnose wrote.");
    phi_ = *phi;
    for (const EffectTerm& term : arm.arm_effects()) left_out_.push_back(term.effect + " on the arm");
    for (const EffectTerm& term : arm.effects()) {
      const EffectFacts effect(arm, term);
      require(effect.has_values(), "export: arm '", arm.name(), "' has ", term.effect,
              " without values, expected a MODEL that identify or diagnose wrote.");
      if (dynamic_cast<const WrittenInC*>(&effect.effect()) == nullptr) {
        left_out_.push_back(term.effect + " on " + axis_text(arm, term.axis));
      } else {
        effects_.push_back(effect);
      }
    }
  }

  std::string code() {
    write_rigid_bodies();
    write_friction();
    write_torque();
    const std::string functions = std::exchange(out_, {});
    write_head();
    write_constants();
    write_helpers();
    out_ += functions;
    write_double_wrappers();
    write_line("#endif");
    return std::move(out_);
  }

 private:
  void write_line(const std::string& content) { out_ += content + "\n"; }

  void write_head() {
    write_line(fmt::format("/* Torques of {}, written by veridyn {}.", safe_c_text(arm_.name()),
                     VERIDYN_VERSION));
    write_line(" * C99 and C++, without dependencies. SI units: rad, m, kg, N m, N, s.");
    write_line(fmt::format(" * In C numbers are doubles, or what {}_real was defined as before; in C++", name_));
    write_line(" * the functions are templates over double and float. Matrices are by rows.");
    for (const std::string& one : left_out_) write_line(" * Left out: " + safe_c_text(one) + ".");
    write_line(fmt::format(R"( *
 * memory: {0}_memory numbers of the caller's, one array for each running loop, in which effects with
 * a memory (friction before sliding, backlash) keep where they are. Zeros begin afresh: clear the
 * array before the first cycle and after every pause; nothing else is to be done with it. A cycle:
 *
 *   static double memory[{0}_memory];              begins with zeros
 *   {0}_torque(q, dq, ddq_wanted, memory, tau);    once a cycle, with the states in their order
 *
 * q, dq, ddq and tau are true values. Friction changes its sign with a velocity's: of a measured one,
 * whose noise does so at rest, it chatters. Give the wanted velocity, or define {0}_rest_speed before
 * this file as what the noise does not exceed; below it friction is proportional to the velocity.)", name_));
    const std::vector<std::string> errors = JointSensors(arm_).descriptions(arm_);
    if (!errors.empty()) write_line(" * As the model knows the sensors of this arm, to be taken off before and put on after:");
    for (const std::string& one : errors) write_line(" *   " + safe_c_text(one));
    write_line(" */");
    write_line(fmt::format("#ifndef VERIDYN_{0}\n#define VERIDYN_{0}\n\n#include <math.h>\n", name_));
    write_line(fmt::format("#ifndef {}_API", name_));
    write_line(fmt::format("#ifdef __cplusplus\n#define {0}_API extern \"C\"\n#else\n#define {0}_API\n"
                     "#endif\n#endif\n",
                     name_));
    write_line(fmt::format("#ifdef __cplusplus\n#define {0}_FUNCTION template <typename {0}_real> inline\n"
                     "#define {0}_sin(x) sin(x)\n#define {0}_cos(x) cos(x)\n"
                     "#else\n#ifndef {0}_real\n#define {0}_real double\n#endif\n"
                     "#define {0}_FUNCTION {0}_API\n"
                     "#define {0}_sin(x) (sizeof({0}_real) == sizeof(float) ? sinf((float)(x)) : sin(x))\n"
                     "#define {0}_cos(x) (sizeof({0}_real) == sizeof(float) ? cosf((float)(x)) : cos(x))\n"
                     "#endif\n",
                     name_));
  }

  void write_constants() {
    const std::size_t bodies = arm_.bodies().size();
    write_line(fmt::format("enum {{ {0}_joints = {1}, {0}_bodies = {2}, {0}_parameters = {3}, "
                     "{0}_memory = {4} }};\n",
                     name_, arm_.joints(), bodies, kBodyParameters * bodies,
                     std::max<std::size_t>(1, kMemory * effects_.size())));
    write_line("/* Coordinates, in the order of q, dq, ddq and tau. */");
    write_line(fmt::format("static const char* const {0}_joint_names[{0}_joints] = {{", name_));
    for (const Coordinate& c : arm_.coordinates()) write_line("  \"" + safe_c_text(c.name) + "\",");
    write_line("};\n");
    write_line("/* Inertial parameters, in the order of the regressor's columns: mass [kg], mass times");
    write_line("   centre [kg m], inertia about the frame's origin [kg m^2]. */");
    write_line(fmt::format("static const double {0}_phi[{0}_parameters] = {{", name_));
    for (Eigen::Index j = 0; j < phi_.size(); ++j) write_line("  " + c_number(phi_[j]) + ",");
    write_line("};\n");
    write_line(fmt::format("static const char* const {0}_parameter_names[{0}_parameters] = {{", name_));
    for (const auto [k] : arm_.bodies()) {
      for (const char* symbol : kSymbols)
        write_line(fmt::format("  \"{}_{}\",", symbol, safe_c_text(arm_.frames()[k].name)));
    }
    write_line("};\n");
  }

  // Writes those helper functions of WrittenInC::c_columns() that the functions call.
  void write_helpers() {
    const auto called = [&](const char* helper) { return called_.count(helper) != 0; };
    const bool contact = called("contact");
    if (called("direction")) {
      write_line(fmt::format(R"(/* The sign of a velocity, a straight line below {0}_rest_speed rad/s or m/s. */
#ifndef {0}_rest_speed
#define {0}_rest_speed {1}
#endif
static double {0}_direction(double ds) {{
  const double d = ds / {0}_rest_speed;
  return d < -1.0 ? -1.0 : d > 1.0 ? 1.0 : d;
}}
)",
                       name_, c_number(kRestSpeed)));
    }
    if (contact || called("clamp")) {
      write_line(fmt::format(R"(static double {0}_clamp(double x) {{
  return x < -1.0 ? -1.0 : x > 1.0 ? 1.0 : x;
}}
)",
                       name_));
    }
    if (contact || called("step")) {
      write_line(fmt::format(R"(/* The way since the call before. */
static double {0}_step(double s, double* z) {{
  const double step = z[2] != 0.0 ? s - z[1] : 0.0;
  z[1] = s;
  z[2] = 1.0;
  return step;
}}
)",
                       name_));
    }
    if (contact) {
      write_line(fmt::format(R"(/* How far a contact is sheared, -1 to 1 (Dahl). */
static double {0}_contact(double s, double distance, double* z) {{
  const double step = {0}_step(s, z);
  const double side = step < 0.0 ? -1.0 : 1.0;
  z[0] = {0}_clamp(z[0] - (side - z[0]) * expm1(-fabs(step) / distance));
  return z[0];
}}
)",
                       name_));
    }
  }

  using Values = std::vector<std::pair<std::string, Traced>>;
  using Vector = ArmDynamics<Traced>::Vector;
  using Matrix = ArmDynamics<Traced>::Matrix;

  static Vector input(TracedProgram& program, const char* name, int n) {
    Vector out(n);
    for (int i = 0; i < n; ++i) out[i] = program.input(fmt::format("{}[{}]", name, i));
    return out;
  }

  static void add(const char* name, const Vector& from, Values& to) {
    for (Eigen::Index i = 0; i < from.size(); ++i)
      to.emplace_back(fmt::format("{}[{}]", name, i), from[i]);
  }

  static void add(const char* name, const Matrix& from, Values& to) {
    for (Eigen::Index i = 0; i < from.rows(); ++i) {
      for (Eigen::Index j = 0; j < from.cols(); ++j)
        to.emplace_back(fmt::format("{}[{}]", name, i * from.cols() + j), from(i, j));
    }
  }

  // Writes one algorithm of ArmDynamics as straight-line code for this arm, after `first`.
  template <typename Run>
  void write_traced_function(const std::string& what, const std::string& function,
              const std::vector<const char*>& in, const std::vector<const char*>& out,
              const Run& run, const char* first = "") {
    TracedProgram program;
    const int n = arm_.joints();
    ArmDynamics<Traced> dynamics(tree_, phi_.data());
    std::vector<Vector> given;
    for (const char* name : in) given.push_back(input(program, name, n));
    Values results;
    run(dynamics, given, results);
    this->write_function(what, function, in, out, first + program.statements(results));
  }

  void write_rigid_bodies() {
    const int n = arm_.joints();
    const auto p = static_cast<Eigen::Index>(kBodyParameters * arm_.bodies().size());
    write_traced_function("tau = M(q) ddq + C(q, dq) dq + g(q): the rigid bodies.", "inverse_dynamics",
           {"q", "dq", "ddq"}, {"tau"}, [&](auto& arm, const auto& x, Values& to) {
             Vector tau(n);
             arm.inverse_dynamics(x[0], x[1], x[2], tau);
             add("tau", tau, to);
           });
    write_traced_function("g(q).", "gravity", {"q"}, {"tau"}, [&](auto& arm, const auto& x, Values& to) {
      Vector tau(n);
      arm.gravity_torques(x[0], tau);
      add("tau", tau, to);
    });
    write_traced_function("M(q).", "mass_matrix", {"q"}, {"M"}, [&](auto& arm, const auto& x, Values& to) {
      Matrix M(n, n);
      arm.mass_matrix(x[0], M);
      add("M", M, to);
    });
    write_traced_function("ddq = M^-1 (tau - C dq - g).", "forward_dynamics", {"q", "dq", "tau"}, {"ddq"},
           [&](auto& arm, const auto& x, Values& to) {
             Vector ddq(n);
             arm.forward_dynamics(x[0], x[1], x[2], ddq);
             add("ddq", ddq, to);
           });
    write_traced_function("Derivatives of inverse_dynamics by q and dq; that by ddq is M.", "derivatives",
           {"q", "dq", "ddq"}, {"by_q", "by_dq"}, [&](auto& arm, const auto& x, Values& to) {
             Vector tau(n);
             Matrix by_q(n, n), by_dq(n, n), M(n, n);
             arm.inverse_dynamics_derivatives(x[0], x[1], x[2], tau, by_q, by_dq, M);
             add("by_q", by_q, to);
             add("by_dq", by_dq, to);
           });
    write_traced_function(fmt::format("tau = Y * {}_phi.", name_), "regressor", {"q", "dq", "ddq"}, {"Y"},
           [&](auto& arm, const auto& x, Values& to) {
             Matrix Y(n, p);
             arm.regressor(x[0], x[1], x[2], Y);
             add("Y", Y, to);
           },
           "  (void)@phi, (void)@joint_names, (void)@parameter_names;\n");
  }

  // Writes a function with the array arguments `in` and `out`. The text of write_torque() explains the effects' memory.
  void write_function(const std::string& what, const std::string& name,
                const std::vector<const char*>& in, const std::vector<const char*>& out,
                const std::string& body) {
    const auto arguments = [&](const std::string& type) {
      std::string list;
      for (const char* one : in) list += fmt::format("const {} {}[], ", type, one);
      for (const char* one : out) {
        const bool memory = std::string(one) == "memory";
        list += fmt::format("{} {}[], ", memory ? "double" : type, one);
      }
      return list.substr(0, list.size() - 2);
    };
    write_line("/* " + what + " */");
    write_line(fmt::format("{0}_FUNCTION void {0}_{1}({2}) {{", name_, name, arguments(name_ + "_real")));
    write_line(fmt::format("  typedef {}_real R;", name_));
    write_line("  (void)sizeof(R);");
    for (const char* one : in) write_line(fmt::format("  (void){};", one));
    for (const char* helper : {"direction", "clamp", "step", "contact"}) {
      if (body.find(std::string("@") + helper + "(") != std::string::npos) called_.insert(helper);
    }
    for (const char c : body) {
      if (c == '@') out_ += name_ + "_";
      else out_ += c;
    }
    write_line("}\n");
    std::string passed;
    for (const auto* list : {&in, &out}) {
      for (const char* one : *list) passed += (passed.empty() ? "" : ", ") + std::string(one);
    }
    for_doubles_ += fmt::format("{0}_API void {0}_{1}({2}) {{ {0}_{1}<double>({3}); }}\n", name_,
                                name, arguments("double"), passed);
  }

  void write_double_wrappers() {
    write_line("#ifdef __cplusplus\n/* For C and for whoever loads the compiled file. */");
    out_ += for_doubles_;
    write_line("#endif\n");
  }

  // Writes one effect: its columns at this state, times its values, along its axis.
  std::string effect(std::size_t index) {
    const EffectFacts& one = effects_[index];
    const EffectTerm& term = one.term();
    const Axis& axis = term.axis;
    std::string out = fmt::format("  {{ /* {} on {} */\n", term.effect,
                                  safe_c_text(axis_text(arm_, axis)));
    const auto define = [&out](const char* variable, const std::string& value) {
      out += fmt::format("    const double {} = {};\n", variable, value);
    };
    define("s", linear_form(axis, "q", axis.offset));
    define("ds", linear_form(axis, "dq", 0.0));
    define("dds", linear_form(axis, "ddq", 0.0));
    if (term.from) {
      define("from_s", linear_form(*term.from, "q", term.from->offset));
      define("from_ds", linear_form(*term.from, "dq", 0.0));
    }
    if (one.traits().uses_load) {
      Axis share = axis;
      share.coefficients /= axis.coefficients.squaredNorm();
      define("load", linear_form(share, "rigid", 0.0));
    }
    out += fmt::format("    double* const z = memory + {};\n", kMemory * index);
    std::string force;
    const auto& written = dynamic_cast<const WrittenInC&>(one.effect());
    const std::string before = written.c_before(one.shape());
    if (!before.empty()) out += "    " + before + "\n";
    const std::vector<std::string> columns = written.c_columns(one.shape());
    for (std::size_t p = 0; p < columns.size(); ++p) {
      force += (p == 0 ? "" : " +\n                         ") + c_number(one.values()[p]) + " * (" +
               columns[p] + ")";
    }
    define("force", force);
    out += "    (void)s, (void)ds, (void)dds, (void)z;\n";
    for (Eigen::Index i = 0; i < axis.coefficients.size(); ++i) {
      if (axis.coefficients[i] == 0.0) continue;
      out += fmt::format("    tau[{}] += {} * force;\n", i, c_number(axis.coefficients[i]));
    }
    return out + "  }\n";
  }

  void write_friction() {
    bool loaded = false;
    for (const EffectFacts& one : effects_) loaded = loaded || one.traits().uses_load;
    std::string body = "  int i;\n";
    if (loaded) {
      body += fmt::format("  R rigid[{0}_joints];\n  {0}_inverse_dynamics(q, dq, ddq, rigid);\n",
                          name_);
    }
    body += fmt::format("  (void)memory;\n  for (i = 0; i < {}_joints; ++i) tau[i] = 0.0;\n", name_);
    for (std::size_t k = 0; k < effects_.size(); ++k) body += effect(k);
    write_function("Friction and every other effect of the model.", "friction", {"q", "dq", "ddq"},
             {"memory", "tau"}, body);
  }

  void write_torque() {
    write_function("The whole torque of the motors.", "torque", {"q", "dq", "ddq"}, {"memory", "tau"},
             fmt::format("  int i;\n  R rigid[{0}_joints];\n"
                         "  {0}_inverse_dynamics(q, dq, ddq, rigid);\n"
                         "  {0}_friction(q, dq, ddq, memory, tau);\n"
                         "  for (i = 0; i < {0}_joints; ++i) tau[i] += rigid[i];\n",
                         name_));
  }

  const Model& arm_;
  Tree tree_;
  std::string name_;
  VectorXd phi_;
  std::vector<EffectFacts> effects_;
  std::vector<std::string> left_out_;
  std::set<std::string> called_;  // helper functions that are called
  std::string out_, for_doubles_;
};

}  // namespace

std::string to_c_code(const Model& arm) {
  return CWriter(arm).code();
}

void save_c_code(const Model& arm, const std::string& path) {
  write_file(path, to_c_code(arm));
}

}  // namespace veridyn
