#pragma once

/// Main header of the library: reading robots and recordings, identification, diagnosis,
/// comparison, design of motions, simulation, control, export. Boards and cooperation have headers
/// of their own in veridyn/dvrk and veridyn/cooperation.

#include "veridyn/comparison/model_comparison.hpp"
#include "veridyn/control/arm_state.hpp"
#include "veridyn/control/computed_torque.hpp"
#include "veridyn/control/friction_compensation.hpp"
#include "veridyn/control/gravity_compensation.hpp"
#include "veridyn/control/impedance.hpp"
#include "veridyn/control/model_error_observer.hpp"
#include "veridyn/control/momentum_observer.hpp"
#include "veridyn/diagnosis/diagnosis.hpp"
#include "veridyn/diagnosis/payload.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/dynamics/torque_regressor.hpp"
#include "veridyn/excitation/excitation.hpp"
#include "veridyn/identification/identification.hpp"
#include "veridyn/kinematics/kinematics.hpp"
#include "veridyn/model/model_file.hpp"
#include "veridyn/model/simulator_files.hpp"
#include "veridyn/model/urdf.hpp"
#include "veridyn/recordings/recording_list.hpp"
#include "veridyn/recordings/recording_quality.hpp"
#include "veridyn/report/diagnosis_json.hpp"
#include "veridyn/report/pages.hpp"
#include "veridyn/report/json.hpp"
#include "veridyn/simulation/joint_torques.hpp"
#include "veridyn/simulation/plant.hpp"
#include "veridyn/simulation/simulate_controlled.hpp"
#include "veridyn/simulation/simulate_recording.hpp"
