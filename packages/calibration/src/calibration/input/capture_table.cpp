#include "capture_table.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>

#include "veridyn/model/excerpt.hpp"
#include "capture_formats.hpp"
#include "veridyn/math/numbers.hpp"
#include "veridyn/recordings/csv/csv_layout.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::internal {
namespace {

using Kind = CaptureColumn::Kind;

constexpr double kQuaternionNorm = 0.02;  // tolerance of a recorded quaternion's norm
constexpr double kLargest = 50.0;  // [m] positions beyond the range of cameras: the unit must be another one
constexpr double kLargestAngle = 2.0 * M_PI + 1e-6;  // [rad] largest magnitude of a rotation vector
constexpr int kComponents = 7;
constexpr int kRead = 10;  // number of components with a rotation vector, which becomes the quaternion

// Assembles rows into frames; a frame is one row (wide), or the rows of one time (long).
class CaptureReader {
 public:
  CaptureReader(const std::string& path, const CaptureOptions& options)
      : path_(path), options_(options), lines_(path), header_(read_capture_header(lines_)) {}

  CaptureTable read() {
    register_columns();
    std::string_view line;
    for (bool first = true; lines_.next(&line); first = false) {
      const std::vector<std::string> fields = csv_fields(line, header_.separator);
      if (first && header_.padded && reads_column_names(fields)) continue;
      read_row(fields);
    }
    return assembled_table();
  }

 private:
  // "file:line:column", with the column from 1.
  std::string where(std::size_t column) const {
    return text(path_, ":", lines_.number(), ":", column + 1);
  }

  // True if the line is a row of column names, as Track Manager may write it; its columns before the markers
  // (frame, time) are then added to the header.
  bool reads_column_names(const std::vector<std::string>& fields) {
    if (fields[0] != "Frame") return false;
    std::vector<CaptureColumn> before(1);
    if (fields.size() > 1 && fields[1] == "Time") before.push_back(parsed_column("t"));
    header_.columns.insert(header_.columns.begin(), before.begin(), before.end());
    metres_.insert(metres_.begin(), before.size(), 1.0);
    return true;
  }

  // Checks the columns and stores the unit of each; throws InvalidInput on a duplicate, no position or a
  // missing joint.
  void register_columns() {
    std::map<std::string, int> seen;
    std::vector<int> joints;
    metres_.assign(header_.columns.size(), 1.0);
    for (std::size_t k = 0; k < header_.columns.size(); ++k) {
      const CaptureColumn& c = header_.columns[k];
      if (c.kind == Kind::kIgnored) continue;
      if (c.kind == Kind::kComponent && c.index < 3) metres_[k] = metres_per_unit(c);
      const std::string key = text(static_cast<int>(c.kind), " ", c.object, " ", c.index);
      require(++seen[key] == 1 || header_.padded, path_, ":", lines_.number(), ":", k + 1,
              ": found column '", c.name, "' twice, expected it once.");
      is_long_ = is_long_ || c.kind == Kind::kObjectName || c.kind == Kind::kBodyName;
      has_positions_ = has_positions_ || c.kind == Kind::kComponent;
      if (c.kind == Kind::kJoint) joints.push_back(c.index);
    }
    require(has_positions_, path_, ":", lines_.number(),
            ": found no column of a position, expected t,x,y,z or t,BODY/MARKER/x,...");
    std::sort(joints.begin(), joints.end());
    for (std::size_t k = 0; k < joints.size(); ++k)
      require(joints[k] == static_cast<int>(k), path_, ":", lines_.number(), ": found q",
              joints[k] + 1, " but no q", k + 1, ", expected joints q1 to qn without a hole.");
    joints_ = joints.size();
  }

  // Value of a field; NaN for a gap; throws InvalidInput for other text.
  double parsed_number(const std::string& field, std::size_t column) const {
    if (field.empty()) return kNaN;
    const char* first = field.data() + (field[0] == '+' ? 1 : 0);
    const char* last = field.data() + field.size();
    double value = 0.0;
    const auto [rest, error] = std::from_chars(first, last, value);
    const bool gap = field == "NaN" || field == "NA" || field == "null";
    if (gap) return kNaN;
    require(error == std::errc() && rest == last && !std::isinf(value), where(column), ": found '",
            excerpt(field), "' in column '", header_.columns[column].name, "', expected a number or a gap.");
    return value;
  }

  // Metres per unit of a column: by the option, its own unit, the file's; 1 if none is stated.
  double metres_per_unit(const CaptureColumn& column) const {
    const std::string& unit = !options_.unit.empty() ? options_.unit : !column.unit.empty() ? column.unit : header_.unit;
    if (unit.empty()) return 1.0;
    const double out = metres_of(unit);
    require(out > 0.0, path_, ":", lines_.number(), ": found '", excerpt(unit), "' as the unit of '", column.name,
            "', expected m, cm or mm; --unit tells it otherwise.");
    return out;
  }

  // Adds a line to the present frame, or begins a frame; throws InvalidInput if fields are missing.
  void read_row(const std::vector<std::string>& fields) {
    const std::size_t count = header_.columns.size();
    std::size_t filled = fields.size();
    while (filled > count && fields[filled - 1].empty()) --filled;
    require(filled == count || (header_.padded && filled < count), path_, ":", lines_.number(),
            ": found ", filled, " fields, expected ", count, " as in the header.");
    double time = kNaN;
    std::string body;
    std::string name;
    std::vector<double> q(joints_, kNaN);
    for (std::size_t k = 0; k < std::min(filled, count); ++k) {
      const CaptureColumn& c = header_.columns[k];
      if (c.kind == Kind::kTime) time = parsed_number(fields[k], k);
      if (c.kind == Kind::kBodyName) body = fields[k];
      if (c.kind == Kind::kObjectName) name = fields[k];
      if (c.kind == Kind::kJoint) q[c.index] = parsed_number(fields[k], k);
    }
    const bool has_time = has_column(Kind::kTime);
    require(!has_time || !std::isnan(time), path_, ":", lines_.number(),
            ": found no time, expected a number in column t.");
    const bool same = is_long_ && has_time && !times_.empty() && time == times_.back();
    if (!same) {
      times_.push_back(has_time ? time : time_by_rate());
      lines_of_.push_back(lines_.number());
      q_.push_back(q);
    }
    if (is_long_) name = body + (body.empty() || name.empty() ? "" : "/") + name;
    require(!is_long_ || !name.empty(), path_, ":", lines_.number(),
            ": found no name, expected the marker or body of the row.");
    read_components(fields, std::min(filled, count), is_long_ ? object_name(name) : "");
  }

  bool has_column(Kind kind) const {
    return std::any_of(header_.columns.begin(), header_.columns.end(),
                       [kind](const CaptureColumn& c) { return c.kind == kind; });
  }

  static std::string object_name(const std::string& name) {
    return parsed_column(name + "/x").object;
  }

  // [s] Time of the next frame of a file without times; without a rate, frames count seconds.
  double time_by_rate() const {
    const double rate = options_.rate > 0.0 ? options_.rate : header_.rate;
    return static_cast<double>(times_.size()) / (rate > 0.0 ? rate : 1.0);
  }

  // Stores the pose components of a line; `of_row` is the object of a line of a long file.
  void read_components(const std::vector<std::string>& fields, std::size_t count,
                  const std::string& of_row) {
    for (std::size_t k = 0; k < count; ++k) {
      const CaptureColumn& c = header_.columns[k];
      if (c.kind != Kind::kComponent) continue;
      double value = parsed_number(fields[k], k);
      if (c.index < 3) value *= metres_[k];
      const std::string& name = is_long_ ? of_row : c.object;
      const auto [found, is_new] = index_.try_emplace(name, objects_.size());
      if (is_new) objects_.push_back({name, {}, false, false});
      Object& object = objects_[found->second];
      const std::size_t size = kRead * times_.size();
      if (object.values.size() < size) object.values.resize(size, kNaN);
      object.values[size - kRead + static_cast<std::size_t>(c.index)] = value;
      object.has_orientation = object.has_orientation || c.index >= 3;
      object.has_quaternion = object.has_quaternion || (c.index >= 3 && c.index < kComponents);
    }
  }

  // All frames as a checked table; throws InvalidInput if there are none.
  CaptureTable assembled_table() {
    CaptureTable out;
    out.source = path_;
    const auto frames = static_cast<Eigen::Index>(times_.size());
    require(frames > 0, path_, ": found a header and no rows, expected frames.");
    out.time = Eigen::Map<const VectorXd>(times_.data(), frames);
    out.lines = lines_of_;
    out.q.resize(frames, static_cast<Eigen::Index>(joints_));
    for (Eigen::Index k = 0; k < frames; ++k) {
      for (Eigen::Index i = 0; i < out.q.cols(); ++i)
        out.q(k, i) = q_[k][i];
    }
    for (Object& o : objects_) {
      o.values.resize(kRead * times_.size(), kNaN);
      MatrixXd values = Eigen::Map<const MatrixXd>(o.values.data(), kRead, frames);
      if (o.has_orientation && !o.has_quaternion) convert_rotation_vectors(values);
      out.objects.push_back({o.name, values.topRows(kComponents), o.has_orientation});
    }
    check_values(out);
    return out;
  }

  // Sets quaternions from axis times angle [rad], as Universal Robots writes it.
  void convert_rotation_vectors(MatrixXd& values) const {
    for (Eigen::Index k = 0; k < values.cols(); ++k) {
      const Eigen::Vector3d r = values.col(k).tail<3>();
      if (!r.allFinite()) continue;
      require(r.norm() <= kLargestAngle, path_, ":", lines_of_[static_cast<std::size_t>(k)], ": found a rotation vector (rx, ry, rz) of norm ",
              r.norm(), ", expected axis times angle in rad, at most 2 pi; degrees and Euler angles are not read, quaternions (qw, qx, qy, qz) are.");
      const double half = 0.5 * r.norm();
      values(3, k) = std::cos(half);
      values.block<3, 1>(4, k) = (half > 0.0 ? std::sin(half) / (2.0 * half) : 0.5) * r;
    }
  }

  // Turns zero quaternions into gaps; throws InvalidInput on norms other than 1 and on positions beyond 50 m.
  void check_values(CaptureTable& table) const {
    for (CapturedObject& o : table.objects) {
      for (Eigen::Index k = 0; k < o.values.cols(); ++k) {
        const std::string at = text(path_, ":", lines_of_[k]);
        auto quaternion = o.values.col(k).tail<4>();
        if (o.has_orientation && quaternion.allFinite()) {
          const double norm = quaternion.norm();
          if (norm == 0.0) quaternion.setConstant(kNaN);
          require(norm == 0.0 || std::abs(norm - 1.0) < kQuaternionNorm, at,
                  ": found a quaternion of norm ", norm, ", expected one of norm 1 (qw, qx, qy, qz).");
        }
        const auto position = o.values.col(k).head<3>();
        require(!(position.array().abs() > kLargest).any(), at, ": found a position ",
                position.array().abs().maxCoeff(),
                " m from the cameras' origin, expected metres (--unit mm reads millimetres).");
      }
    }
  }

  struct Object {
    std::string name;
    std::vector<double> values;
    bool has_orientation;
    bool has_quaternion;
  };
  const std::string& path_;
  const CaptureOptions& options_;
  CsvLines lines_;
  CaptureHeader header_;
  bool is_long_ = false;
  bool has_positions_ = false;
  std::size_t joints_ = 0;
  std::vector<double> metres_;  // metres per unit of each column
  std::vector<double> times_;
  std::vector<long> lines_of_;
  std::vector<std::vector<double>> q_;
  std::vector<Object> objects_;
  std::map<std::string, std::size_t> index_;
};

}  // namespace

CaptureTable read_capture(const std::string& path, const CaptureOptions& options) {
  require(options.unit.empty() || metres_of(options.unit) > 0.0, "unit: found '", options.unit,
          "', expected m, cm or mm.");
  return CaptureReader(path, options).read();
}

}  // namespace veridyn::internal
