// report/: results as text, JSON and pages.
#pragma once

#include <string>
#include <vector>

#include "veridyn/diagnosis/model_comparison.hpp"
#include "veridyn/diagnosis/diagnosis.hpp"
#include "veridyn/diagnosis/friction_study.hpp"
#include "veridyn/diagnosis/payload.hpp"
#include "veridyn/excitation/excitation.hpp"
#include "veridyn/identification/fleet.hpp"
#include "veridyn/recordings/recording_quality.hpp"
#include "veridyn/report/robot_info.hpp"

namespace veridyn {

// Pages of `veridyn COMMAND --report`: one HTML file that needs neither a network nor other files. Its first
// screen shows what was done, whether the result is good and what to do next; figures can be saved, and the
// drawing of the arm moves. Every number in its text comes from to_json(), which the page contains as the
// element "result".
//
// @param command  the command line of the run, shown verbatim; empty: none.

/// @param robot  the robot file: its values, if any, are shown next to the identified ones.
/// @throws InvalidInput  there is no model.
std::string to_page(const Identification& id, const std::string& command = "",
                    const Model* robot = nullptr);

/// @param next_command  as in Diagnosis::report(). @throws InvalidInput  there is no model.
std::string to_page(const Diagnosis& diagnosis, const std::string& command = "",
                    const std::string& next_command = "");

/// @param arm  arm that is drawn in motion; null: no drawing. @throws InvalidInput  the excitation has no
///   motion.
std::string to_page(const Excitation& excitation, const std::string& command = "",
                    const Model* arm = nullptr);

/// The page of any result, chosen by the `command` of its JSON; the arm is the only input beside
/// it.
std::string result_page(const std::string& title, const std::string& result,
                        const std::string& report, const std::string& command,
                        const Model* arm = nullptr);

std::string to_page(const RobotInfo& info, const std::string& command = "");
std::string to_page(const std::vector<RecordingQuality>& recordings, const std::string& command = "");
std::string to_page(const PayloadReport& report, const std::string& command = "");
/// @param arm  gives the names of the joints; null: the model fitted in the study, if there is one.
std::string to_page(const FrictionStudy& study, const std::string& command = "", const Model* arm = nullptr);
std::string to_page(const ModelComparison& comparison, const std::string& command = "");
std::string to_page(const Fleet& fleet, const std::string& command = "");

/// One page for a folder and its subfolders: MODEL files by date, the changes from each to the next
/// (see compare()), recordings, and links to the other pages.
/// @param output  path of the page, from which links are relative.
/// @throws InvalidInput  the folder does not exist or holds no file of veridyn.
std::string project_page(const std::string& folder, const std::string& output,
                         const std::string& command = "");

/// The result that this page shows, as JSON.
std::string project_json(const std::string& folder, const std::string& output);

}  // namespace veridyn
