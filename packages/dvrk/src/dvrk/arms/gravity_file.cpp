#include <charconv>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "veridyn/model/excerpt.hpp"
#include "veridyn/model/suggestion.hpp"
#include "veridyn/recordings/csv/csv_layout.hpp"
#include "veridyn/recordings/csv/csv_lines.hpp"
#include "dvrk/arms/gravity_chain.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

using Json = nlohmann::ordered_json;

Json row_json(const GravityRow& row) {
  // The joint variable adds "offset" to theta or D, which is then zero.
  return {{"name", row.joint},
          {"type", row.prismatic ? "prismatic" : "revolute"},
          {"mode", "active"},
          {"offset", row.prismatic ? row.dh.d : row.dh.theta},
          {"alpha", row.dh.alpha},
          {"A", row.dh.a},
          {"theta", row.prismatic ? row.dh.theta : 0.0},
          {"D", row.prismatic ? 0.0 : row.dh.d},
          {"mass", row.mass},
          {"cx", row.com.x()},
          {"cy", row.com.y()},
          {"cz", row.com.z()}};
}

// Index of the joint of a column, from 0: 2 for prefix + "3"; -1 for other columns.
int joint_index_of(const std::string& column, const std::string& prefix) {
  if (column.rfind(prefix, 0) != 0 || column.size() == prefix.size()) return -1;
  int joint = 0;
  const char* end = column.data() + column.size();
  const auto [stop, error] = std::from_chars(column.data() + prefix.size(), end, joint);
  return error == std::errc() && stop == end && joint > 0 ? joint - 1 : -1;
}

// Indices of the columns q1..qn and tau1..taun.
struct Columns {
  std::map<int, std::size_t> q, tau;
  std::size_t count = 0;
};

Columns columns_of(const std::vector<std::string>& fields, bool header, const std::string& where) {
  Columns columns;
  columns.count = fields.size();
  if (!header) {
    require(fields.size() % 2 == 0, where, ": found ", fields.size(),
            " columns without a header, expected as many efforts as positions.");
    const std::size_t n = fields.size() / 2;
    for (std::size_t k = 0; k < n; ++k) {
      columns.q[static_cast<int>(k)] = k;
      columns.tau[static_cast<int>(k)] = n + k;
    }
    return columns;
  }
  for (std::size_t k = 0; k < fields.size(); ++k) {
    const int position = joint_index_of(fields[k], "q"), effort = joint_index_of(fields[k], "tau");
    const bool is_new = (position < 0 || columns.q.emplace(position, k).second) && (effort < 0 || columns.tau.emplace(effort, k).second);
    require(is_new, where, ": found the column '", excerpt(fields[k]), "' twice.");
  }
  const int n = static_cast<int>(columns.q.size());
  require(n > 0 && columns.tau.size() == columns.q.size() && columns.q.rbegin()->first == n - 1 &&
              columns.tau.rbegin()->first == n - 1,
          where, ": found the header ", listed(fields), ", expected q1..qn and tau1..taun.");
  return columns;
}

// Finite number; throws InvalidInput for other text.
double parse_number(const std::string& field, const std::string& where) {
  double value = 0.0;
  const char* end = field.data() + field.size();
  const auto [stop, error] = std::from_chars(field.data(), end, value);
  require(error == std::errc() && stop == end && std::isfinite(value), where, ": found '", excerpt(field),
          "', expected a finite number.");
  return value;
}

}  // namespace

std::string to_gravity_json(const GravityChain& chain, const std::string& model) {
  Json joints = Json::array();
  for (const GravityRow& row : chain.rows) joints.push_back(row_json(row));
  Json errors = Json::object();
  for (std::size_t k = 0; k < chain.joints.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    errors[chain.joints[k]] = {{"largest_torque", chain.largest_torque[i]},
                               {"largest_error", chain.largest_error[i]}};
  }
  const Json file = {
      {"DH", {{"convention", "modified"}, {"joints", joints}}},
      {"veridyn",
       {{"arm", chain.arm},
        {"model", model},
        {"gravity", chain.gravity},
        {"meaning",
         "masses and centres stand for gravity torques of the whole arm, counterweights "
         "included, not for single bodies"},
        {"not_in_the_rows", chain.left_out},
        {"gravity_torques", errors}}}};
  return file.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

StaticTorques read_static_torques(const std::string& path) {
  CsvLines lines(path);
  std::string_view line;
  Columns columns;
  std::vector<double> values;
  char separator = ',';
  while (lines.next(&line)) {
    const std::string where = text(path, ":", lines.number());
    const bool first = columns.count == 0;
    if (first) separator = csv_separator(line);
    const std::vector<std::string> fields = csv_fields(line, separator);
    if (first) {
      const bool header = !is_row_of_numbers(line);
      columns = columns_of(fields, header, where);
      if (header) continue;
    }
    require(fields.size() == columns.count, where, ": found ", fields.size(), " fields, expected ",
            columns.count, " as above.");
    for (const auto& [joint, k] : columns.q) values.push_back(parse_number(fields[k], where));
    for (const auto& [joint, k] : columns.tau) values.push_back(parse_number(fields[k], where));
  }
  require(!values.empty(), path, ": found no rows of numbers, expected positions and efforts.");
  const auto n = static_cast<Eigen::Index>(columns.q.size());
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Eigen::Map<const Rows> all(values.data(),
                                   static_cast<Eigen::Index>(values.size()) / (2 * n), 2 * n);
  return {all.leftCols(n), all.rightCols(n)};
}

}  // namespace veridyn::dvrk
