// model/: a robot as frames, bodies and effects, and nothing that computes with samples.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "veridyn/math/types.hpp"
#include "veridyn/math/vector3.hpp"
#include "veridyn/model/identified_base.hpp"
#include "veridyn/model/joint_type.hpp"

namespace veridyn {

/// Largest number of coordinates of a model; computation times grow with its cube.
constexpr int kMostCoordinates = 500;
/// Largest number of bodies of a model, including bodies that are fixed to others.
constexpr int kMostBodies = 2000;

/// A joint variable or the line along which an effect acts: s = c . q + s0.
struct Axis {
  VectorXd coefficients;  ///< c, (n)
  double offset = 0.0;    ///< s0 [rad] or [m]
};

enum class DhConvention { kStandard, kModified };

/// Four Denavit-Hartenberg numbers.
///
///   standard: T = Rz(theta) Tz(d) Tx(a) Rx(alpha)
///   modified: T = Rx(alpha) Tx(a) Rz(theta) Tz(d)
struct DhRow {
  DhConvention convention = DhConvention::kStandard;
  double a = 0.0;      ///< [m]
  double alpha = 0.0;  ///< [rad]
  double d = 0.0;      ///< [m]
  double theta = 0.0;  ///< [rad]
};

/// The ten inertial parameters of one body, in which torques are linear. **Their order is defined here:**
///
///   phi = [m, hx, hy, hz, Lxx, Lxy, Lyy, Lxz, Lyz, Lzz]
///
/// mass [kg], first moment h = m c [kg m], and the inertia tensor L [kg m^2] about the *origin* of
/// the body's frame, all written in that frame.
using InertialParameters = Eigen::Matrix<double, 10, 1>;
constexpr int kBodyParameters = 10;

/// Inertial parameters from mass [kg], centre of mass [m] and the inertia about that centre [kg m^2] (xx, xy,
/// yy, xz, yz, zz).
InertialParameters inertial_parameters(double mass, const Eigen::Vector3d& com,
                                       const Eigen::Matrix<double, 6, 1>& inertia_com);

/// Bounds that the file declares for every body (`box:`) or for one (`box:` in its body); feasible
/// least squares keeps to them and needs them for a rigorous duality gap.
struct ParameterBox {
  double mass_max = 0.0;  ///< [kg]; 0: none
  double com_reach =
      0.0;  ///< [m] largest |c_x|, |c_y|, |c_z|; no mass lies twice as far from the origin; 0: none
  /// Largest |value| of every parameter of every effect, in SI units (top level only); 0: none.
  double effect_max = 0.0;
};

/// Provenance of the values in a robot file.
enum class RobotValues {
  kFacts,  ///< values of this very arm, as in an identified model
  kPrior,  ///< values of its series: a manufacturer's file (URDF), or `values: prior` in YAML
};

/// "facts", "prior".
const char* name_of(RobotValues values);

/// A rigid body that moves with its frame.
struct Body {
  std::optional<InertialParameters> phi;      ///< known, initial or identified values
  std::optional<InertialParameters> std_phi;  ///< standard deviations of identified values
  /// Values of the manufacturer's file: an identification is regularised towards them in the
  /// directions that the recordings do not determine.
  std::optional<InertialParameters> prior;
  bool fixed = false;                         ///< true: the values are facts and are not identified
  ParameterBox box;                           ///< bounds of this body, where given
};

/// Index of a generalized coordinate, from 0. People read its name or its number from 1.
struct JointIndex {
  int value = 0;
};

/// Index of a frame in Model::frames().
struct FrameIndex {
  int value = 0;
};

inline bool operator==(JointIndex a, JointIndex b) {
  return a.value == b.value;
}
inline bool operator!=(JointIndex a, JointIndex b) {
  return a.value != b.value;
}
inline bool operator<(JointIndex a, JointIndex b) {
  return a.value < b.value;
}
inline bool operator==(FrameIndex a, FrameIndex b) {
  return a.value == b.value;
}
inline bool operator!=(FrameIndex a, FrameIndex b) {
  return a.value != b.value;
}

/// One frame of the tree. T_parent_frame = A * J(s) * B, where J turns about z or slides along z.
struct Frame {
  std::string name;
  std::optional<FrameIndex> parent;  ///< nullopt: the world
  JointType type = JointType::kFixed;
  Axis variable;              ///< s; coefficients are zero where fixed
  Posed A = identity_pose();  ///< T_parent_joint
  Posed B = identity_pose();  ///< T_joint_frame
  std::optional<DhRow> dh;    ///< the DH row of the file, for hypotheses about wrong constants
  std::optional<Body> body;
};

/// Range of one coordinate; infinite where the file gives none.
struct Limits {
  double lower;
  double upper;
  double velocity;
  double acceleration;
  double effort;
};

/// Errors of a joint's sensors, as diagnosed; JointSensors corrects them.
struct RecordedChannel {
  double torque_gain = 1.0;      ///< recorded torque per true torque
  double torque_delay = 0.0;     ///< [s] lag of the recorded torque
  double position_offset = 0.0;  ///< [rad] or [m] recorded position minus true position
  /// Recorded torque per true torque of other joints; none of its own.
  std::map<JointIndex, double> torque_crosstalk{};
};

struct Coordinate {
  std::string name;
  Limits limits;
  double drive_gain = 0.0;  ///< [N m/A] or [N/A]: torque per ampere of motor current; 0: not given
  /// True where the coordinate moves prismatic frames only: metres and newtons.
  bool prismatic = false;
  double drive_gain_deviation = 0.0;  ///< standard deviation of an identified drive gain; 0: none
  RecordedChannel recorded{};
};

/// One effect of the model, by its name in docs/contract.md; src/effects/ has its equations.
struct EffectTerm {
  std::string effect;
  Axis axis;                                 ///< axis along which the effect acts
  std::optional<Axis> from;                  ///< the other coordinate of a coupling
  std::string frame;                         ///< the frame that a payload sits on; empty otherwise
  std::map<std::string, double> values;      ///< parameters and shape constants by name
  std::map<std::string, double> deviations;  ///< standard deviations of identified parameters
  bool fixed = false;                        ///< true: the values are facts and are not identified
  std::string where;                         ///< file and line, for messages
};

/// Contents of a robot file.
struct ModelDescription {
  std::string name;
  std::string source;  ///< origin of the numbers, in words
  RobotValues values = RobotValues::kFacts;
  Eigen::Vector3d gravity{0.0, 0.0, -9.81};
  std::map<std::string, double> constants;
  std::vector<Coordinate> coordinates;
  std::vector<Frame> frames;  ///< parents before children
  std::vector<EffectTerm> effects;
  /// Effects on the arm as a whole, with values and without an axis, such as a compliant base; see
  /// ArmEffect.
  std::vector<EffectTerm> arm_effects;
  ParameterBox box;
  std::map<std::string, std::string>
      formulas;  ///< arithmetic expressions of the file, by path, as "frames/elbow/dh/3"
  /// Statistics of the identification that gave the values; empty in a robot file, and after any
  /// change of the values.
  std::optional<IdentifiedBase> identified;
};

/// An arm: frames, bodies and effects. Immutable.
class Model {
 public:
  /// An empty model without joints, to which a model can be assigned.
  Model() = default;

  /// @throws InvalidInput  a frame precedes its parent, names are not unique, or sizes differ.
  explicit Model(ModelDescription description);

  const std::string& name() const { return description_.name; }
  const ModelDescription& description() const { return description_; }
  const Eigen::Vector3d& gravity() const { return description_.gravity; }
  const std::vector<Coordinate>& coordinates() const { return description_.coordinates; }
  const std::vector<Frame>& frames() const { return description_.frames; }
  const std::vector<EffectTerm>& effects() const { return description_.effects; }
  const std::vector<EffectTerm>& arm_effects() const { return description_.arm_effects; }

  /// n, the number of generalized coordinates.
  int joints() const { return static_cast<int>(description_.coordinates.size()); }

  /// The frames that carry a body, in the order of their columns in the regressor.
  const std::vector<FrameIndex>& bodies() const { return bodies_; }

  /// The frame or the coordinate with this name; nullopt: there is none.
  std::optional<FrameIndex> find_frame(const std::string& name) const;
  std::optional<JointIndex> find_coordinate(const std::string& name) const;

  /// The inertial parameters of all bodies, (10 * bodies), or nothing if one of them has no values.
  std::optional<VectorXd> inertial_values() const;

  /// True if the joint moves the frame.
  bool moves(FrameIndex frame, JointIndex joint) const { return support_[frame.value][joint.value] != 0; }

 private:
  ModelDescription description_;
  std::vector<FrameIndex> bodies_;
  std::vector<std::vector<char>> support_;
};

/// Sets dh, A and B of a frame, and adds theta (revolute) or d (prismatic) to its offset; its type must be set.
void place(Frame& frame, const DhRow& dh);

/// The units of a coordinate's effort, "N m" or "N", and of its position, "rad" or "m".
std::string effort_unit(const Coordinate& coordinate);
std::string position_unit(const Coordinate& coordinate);

/// True if the axis' variable is in metres: main_coordinate() is prismatic.
bool is_prismatic(const Model& arm, const Axis& axis);

/// The coordinate with the largest coefficient by magnitude; the first if all are zero.
JointIndex main_coordinate(const Axis& axis);

}  // namespace veridyn
