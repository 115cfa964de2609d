#include "run_end.hpp"

#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {

std::string lateness_text(const CycleClock& clock) {
  return text("the loop is late: ", clock.cycles_in_window(), " of ", clock.cycles_due(),
              " cycles in the last half second; ", describe_reason(clock.timing().longest_gap));
}

std::string objection_to(const LoopTiming& timing) {
  if (timing.measured_rate() >= kLeastRate * timing.rate) return "";
  return text("the loop was late: ", timing.measured_rate(), " cycles per second, expected ", timing.rate,
              "; ", timing.late, " of ", timing.cycles, " cycles began late");
}

void finish(RowFile& file, RunResult& result) {
  if (file.failed() && result.why.empty()) result.why = "the recording cannot be written";
  const std::string also = result.remark.empty() ? "" : "; " + result.remark;
  file.finish(result.why.empty() ? result.remark : "incomplete: " + result.why + also);
  result.kept = file.rows();
  result.file_error = file.error();
  if (!result.file_error.empty() && result.why.empty())
    result.why = "the recording cannot be written";
  result.complete = result.why.empty();
}

}  // namespace veridyn::dvrk
