// Names that a watch gives to a torque offset of pitch, over its onset: every 0.5 s of two motions.
//
//   veridyn-watch-onsets [OFFSET] [SEEDS]

#include <fmt/format.h>

#include <cstdlib>

#include "diagnosis/watch/onsets.hpp"

int main(int count, char** words) {
  using namespace veridyn;
  const double size = count > 1 ? std::atof(words[1]) : 0.3;
  const auto seeds = static_cast<unsigned>(count > 2 ? std::atoi(words[2]) : 1);
  const WatchedArm watched;
  const std::string hidden = fmt::format("torque_offset:pitch:offset={}", size);
  int all = 0, right = 0, impossible = 0, alone = 0;
  for (const double period : {0.0, 10.0}) {
    const MotionSamples motion = watched_waves(40.0, period);
    for (unsigned seed = 1; seed <= seeds; ++seed) {
      const Recording before = watched.recorded(motion, {}, seed);
      const Recording after = watched.recorded(motion, {hidden}, seed);
      for (double onset = 5.0; onset < 30.0; onset += 0.5) {
        const OnsetAnswer a = answer(watched.watched(joined(before, after, onset, onset + 10.0)),
                                     onset, "torque_offset:pitch", size);
        ++all;
        right += a.right;
        impossible += a.impossible;
        alone += a.changes == 1;
        if (!a.right || a.changes != 1)
          fmt::print("period {} s, seed {}, onset {} s{}:\n{}", period, seed, onset,
                     a.right ? "" : ", not right", a.events);
      }
    }
  }
  fmt::print("{} of {} right within 3 s, {} impossible, {} with one change and no other\n", right,
             all, impossible, alone);
  return 0;
}
