#include "veridyn/simulation/simulate_controlled.hpp"

#include "recorded.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/simulation/engine.hpp"

namespace veridyn {
namespace {

VectorXd encoder_steps(const Model& arm, const SensorNoise& noise) {
  VectorXd steps(arm.joints());
  for (int i = 0; i < arm.joints(); ++i) {
    const bool slides = arm.coordinates()[i].prismatic;
    steps[i] = slides ? noise.encoder_step.prismatic : noise.encoder_step.revolute;
  }
  return steps;
}

}  // namespace

ControlledRecording simulate_controlled(const Model& arm, const MotionSamples& wanted,
                                        const ControlledOptions& options) {
  const PerturbedArm injected = inject_effects(arm, options.recording.hidden);
  LoopOptions loop = options.loop;
  // The default gains are tuned for the arm without the hidden effects.
  if (loop.gains.p.size() == 0) loop.gains = sensible_gains(arm);
  loop.sensors.encoder_step = encoder_steps(arm, options.recording.noise);
  loop.contacts = injected.contacts;
  const auto engine = make_engine(options.engine, injected.arm);
  EngineRun run = run_with_pid(*engine, injected.arm, wanted, loop);
  require(run.motion.rows() > 0, "simulation: ", run.stop_reason(arm), ", before the first row.");
  ControlledRecording out{{injected.arm, injected.effects, run.motion, run.tau, run.motion, {}},
                          run,
                          loop.gains,
                          engine->left_out()};
  record(arm, injected, options.recording, out.recording);
  return out;
}

}  // namespace veridyn
