#include "dvrk/run/loop_timing.hpp"

#include <fmt/format.h>

namespace veridyn::dvrk {
namespace {

constexpr double kPlanned = 0.1;  // share of a gap below which its cause is not reported

}  // namespace

LateReason reason_of(const WriteGap& gap) {
  const double system = gap.woken_late + gap.interrupted;
  if (gap.own > system && gap.own > gap.replies) return LateReason::kOwn;
  return gap.replies > system ? LateReason::kReplies : LateReason::kSystem;
}

std::string describe_reason(const WriteGap& gap) {
  const double unplanned = gap.woken_late + gap.interrupted + gap.replies + gap.own;
  if (unplanned < kPlanned * gap.seconds) return "as planned";
  switch (reason_of(gap)) {
    case LateReason::kOwn:
      return fmt::format("this program worked for {:.2f} ms", 1e3 * gap.own);
    case LateReason::kReplies:
      return fmt::format("replies took {:.2f} ms", 1e3 * gap.replies);
    case LateReason::kSystem:
      break;
  }
  return gap.woken_late > gap.interrupted
             ? fmt::format("the system woke this program {:.2f} ms late", 1e3 * gap.woken_late)
             : fmt::format("the system interrupted this program for {:.2f} ms",
                           1e3 * gap.interrupted);
}

}  // namespace veridyn::dvrk
