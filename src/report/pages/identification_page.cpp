#include "veridyn/report/identification_page.hpp"

#include "report/pages/page.hpp"
#include "report/pages/page_series.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/report/json.hpp"

namespace veridyn {

std::string to_page(const Identification& id, const std::string& command) {
  require(id.model.has_value(), "to_page: found an identification without a model: ", id.reason,
          ".");
  std::vector<PlottedRecording> recordings;
  for (const RecordingError& r : id.test) recordings.push_back({"held out", &r, nullptr});
  for (const RecordingError& r : id.train) recordings.push_back({"training", &r, nullptr});
  return html_page({id.robot + ": identified", "identification.html", to_json(id),
                    series_json(*id.model, recordings, command), id.report()});
}

}  // namespace veridyn
