#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "hide_and_seek/board.hpp"

namespace veridyn::seek {

using Json = nlohmann::ordered_json;

/// A benchmark that any tool can enter; the format of its files is in docs/measure.md.

/// Hidden causes of a case with all parameters, as JSON.
Json truth_json(const HiddenCase& hidden);

/// Writes the recordings and robot files of all observable cases to `folder`, with a list of them in
/// folder/cases.json, and the hidden causes to the file `truth`.
/// @throws InvalidInput  the folder holds cases already, or a file cannot be written.
void export_cases(const BoardRequest& request, const std::string& folder, const std::string& truth);

/// Answers every case of a folder by diagnose(), in the format that score() reads.
Json answer_cases(const std::string& folder, const DiagnosisOptions& options);

/// The same by least squares alone, see named_by_least_squares(); `before` is not read.
Json answer_cases_by_least_squares(const std::string& folder, int threads);

/// Judges answers; a case without an answer counts as one that names nothing.
/// @throws InvalidInput  a file is not there or has another form; the message says where.
std::vector<Outcome> score(const std::string& folder, const std::string& answers,
                           const std::string& truth);

}  // namespace veridyn::seek
