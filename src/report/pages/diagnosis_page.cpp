#include "veridyn/report/diagnosis_page.hpp"

#include "report/pages/page.hpp"
#include "report/pages/page_series.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/report/diagnosis_json.hpp"

namespace veridyn {
namespace {

void add_recordings(const char* role, const std::vector<RecordingError>& model,
                    const std::vector<RecordingError>& extended, bool is_extended,
                    std::vector<PlottedRecording>& out) {
  for (std::size_t k = 0; k < model.size(); ++k) {
    const bool both = is_extended && k < extended.size();
    out.push_back({role, &model[k], both ? &extended[k] : nullptr});
  }
}

}  // namespace

std::string to_page(const Diagnosis& d, const std::string& command,
                    const std::string& next_command) {
  require(d.baseline.model.has_value(),
          "to_page: found a diagnosis without a model: ", d.baseline.reason, ".");
  std::vector<PlottedRecording> recordings;
  const bool found = !d.findings.empty();
  add_recordings("held out", d.baseline.test, d.extended.test, found, recordings);
  add_recordings("training", d.baseline.train, d.extended.train, found, recordings);
  return html_page({d.baseline.robot + ": what the model lacks", "diagnosis.html",
                    to_json(d, next_command), series_json(*d.baseline.model, recordings, command),
                    d.report(next_command)});
}

}  // namespace veridyn
