#include "control/refusals.hpp"
#include "veridyn/control/load_cell.hpp"

namespace veridyn {
namespace {

struct Silent final : ForceSource {
  int poll() noexcept override { return 0; }
  double raw() const noexcept override { return 0.0; }
};

TEST(Refusals, ForceChannelRejectsInvalidOptions) {
  using O = ForceChannelOptions;
  refuses<O>({},
             each<O>({&O::largest_silence, &O::range, &O::largest_jump, &O::noisy_share}, {0.0, kNone}) +
                 each<O>({&O::stuck_after}, {-1.0, kNone}) +
                 each<O>({&O::cutoff, &O::latency}, {-1.0, kEndless, kNone}) +
                 Wrongs<O>{[](O& o) { o.noisy_window = 0; }, [](O& o) { o.calibration.scale = 0.0; },
                           [](O& o) { o.calibration.scale = kNone; },
                           [](O& o) { o.calibration.offset = kEndless; }},
             [](const O& o) { ForceChannel(std::make_unique<Silent>(), o); });
  EXPECT_THROW(ForceChannel(nullptr, {}), InvalidInput);
}

}  // namespace
}  // namespace veridyn
