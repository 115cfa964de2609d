#pragma once

#include <string>
#include <vector>

#include "veridyn/comparison/model_comparison.hpp"
#include "veridyn/diagnosis/diagnosis.hpp"
#include "veridyn/diagnosis/friction_study.hpp"
#include "veridyn/diagnosis/payload.hpp"
#include "veridyn/excitation/excitation.hpp"
#include "veridyn/identification/fleet.hpp"
#include "veridyn/recordings/recording_quality.hpp"
#include "veridyn/report/robot_info.hpp"

namespace veridyn {

// What `veridyn COMMAND --report` writes: one HTML file that needs neither a network nor other files.
// Its first screen says what was done, whether it is good and what comes next; figures can be saved,
// and arms move. Every number in its text is one of to_json(), which stands in the page as the
// element "result".
//
// @param command  the command line of the run, shown as it is; empty: none.

/// @param robot  the robot file: where it has values, they are marked beside those identified.
/// @throws InvalidInput  there is no model.
std::string to_page(const Identification& id, const std::string& command = "",
                    const Model* robot = nullptr);

/// @param next_command  as in Diagnosis::report(). @throws InvalidInput  there is no model.
std::string to_page(const Diagnosis& diagnosis, const std::string& command = "",
                    const std::string& next_command = "");

/// @param arm  that moves; null: none is drawn. @throws InvalidInput  the excitation has no motion.
std::string to_page(const Excitation& excitation, const std::string& command = "",
                    const Model* arm = nullptr);

/// A page of any result that a page is known for, by the `command` of its JSON: what figures show
/// beside it is the arm alone.
std::string result_page(const std::string& title, const std::string& result,
                        const std::string& report, const std::string& command,
                        const Model* arm = nullptr);

std::string to_page(const RobotInfo& info, const std::string& command = "");
std::string to_page(const std::vector<RecordingQuality>& recordings, const std::string& command = "");
std::string to_page(const PayloadReport& report, const std::string& command = "");
/// @param arm  whose joints are named; null: those that move.
std::string to_page(const FrictionStudy& study, const std::string& command = "", const Model* arm = nullptr);
std::string to_page(const ModelComparison& comparison, const std::string& command = "");
std::string to_page(const Fleet& fleet, const std::string& command = "");

/// One page for a folder and those below it: its MODEL files in the order of their dates, what changed
/// from one to the next (see compare()), recordings, and links to the other pages.
/// @param output  where the page will stand: links lead from there.
/// @throws InvalidInput  no such folder, or nothing of veridyn's in it.
std::string project_page(const std::string& folder, const std::string& output,
                         const std::string& command = "");

}  // namespace veridyn
