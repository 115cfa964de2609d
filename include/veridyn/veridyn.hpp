#pragma once

/// Includes the whole library: from a robot and its recordings to an identified model, a diagnosis of what the
/// model lacks, and a controller that uses it:
///
///   const Model robot = read_model("arm.urdf");
///   const Recordings train = read_recordings(robot, {"a.csv", "b.csv"}), test = read_recordings(robot, {"c.csv"});
///   const Identification fit = identify(robot, train);
///   for (const JointScore& joint : validate(fit, test)) std::cout << joint << '\n';
///   const Diagnosis why = diagnose(fit, test);
///   for (const Finding& finding : why.findings) std::cout << finding << '\n';
///   save(why.model, "arm.yaml");
///   JointController controller(why.model, {400, 40});
///
/// Also comparison, design of motions, simulation, export. Packages (boards, cooperation, calibration)
/// have headers of their own.

#include "veridyn/diagnosis/model_comparison.hpp"
#include "veridyn/control.hpp"
#include "veridyn/diagnosis/diagnosis.hpp"
#include "veridyn/diagnosis/payload.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/dynamics/torque_regressor.hpp"
#include "veridyn/excitation/excitation.hpp"
#include "veridyn/excitation/fourier_trajectory.hpp"
#include "veridyn/identification/identification.hpp"
#include "veridyn/identification/joint_score.hpp"
#include "veridyn/kinematics/kinematics.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/files/simulator_files.hpp"
#include "veridyn/files/urdf.hpp"
#include "veridyn/recordings/recording_list.hpp"
#include "veridyn/recordings/recording_quality.hpp"
#include "veridyn/report/diagnosis_json.hpp"
#include "veridyn/report/pages.hpp"
#include "veridyn/report/json.hpp"
#include "veridyn/simulation/joint_torques.hpp"
#include "veridyn/simulation/plant.hpp"
#include "veridyn/simulation/simulate_controlled.hpp"
#include "veridyn/simulation/simulate_recording.hpp"
