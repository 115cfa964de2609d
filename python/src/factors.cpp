#include <pybind11/stl.h>

#include "bindings.hpp"
#include "options.hpp"
#include "veridyn/identification/factor_set.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::python {
namespace {

py::bytes compress_call(const py::object& model, const py::object& given, const py::dict& words) {
  Keywords keywords("compress", words);
  const py::object callback = keywords.value_of("progress");
  const Progress progress(callback ? callback : py::none());
  const Model arm = with_fix(keywords, model_of(model));
  const Recordings recordings = recordings_of(given);
  const IdentificationOptions options = read_identification(keywords, progress);
  keywords.expect_all_taken();
  return py::bytes(interruptible(progress, [arm, recordings, options] {
    PreprocessingOptions how = options.preprocessing;
    const std::vector<std::string> names = recordings.register_in(how.in_memory);
    return to_bytes(compress(with_friction(arm, options.friction), names, how, options.threads));
  }));
}

FactorSet factors_of(const std::vector<std::string>& bytes) {
  require(!bytes.empty(), "factors: found none, expected what compress() returns.");
  FactorSet out = factors_from_bytes(bytes.front());
  for (size_t k = 1; k < bytes.size(); ++k)
    out = merge(std::move(out), factors_from_bytes(bytes[k]));
  return out;
}

std::shared_ptr<Identification> identify_factors(const py::object& model,
                                                 const std::vector<std::string>& bytes,
                                                 const py::object& train, const py::object& test,
                                                 const py::dict& words) {
  Keywords keywords("identify", words);
  const py::object callback = keywords.value_of("progress");
  const Progress progress(callback ? callback : py::none());
  const Model arm = with_fix(keywords, model_of(model));
  const Recordings more = recordings_of(train), held_out = recordings_of(test);
  const IdentificationOptions options = read_identification(keywords, progress);
  keywords.expect_all_taken();
  return interruptible(progress, [arm, bytes, more, held_out, options] {
    IdentificationOptions how = options;
    const std::vector<std::string> train_names = more.register_in(how.preprocessing.in_memory);
    const std::vector<std::string> test_names = held_out.register_in(how.preprocessing.in_memory);
    if (how.test_preprocessing) how.test_preprocessing->in_memory = how.preprocessing.in_memory;
    return std::make_shared<Identification>(
        identify(arm, factors_of(bytes), train_names, test_names, how));
  });
}

}  // namespace

void bind_factors(py::module_& m) {
  m.def("compress", &compress_call);
  m.def("merge", [](const std::vector<std::string>& bytes) {
    std::string merged;
    {
      const py::gil_scoped_release free;
      merged = to_bytes(factors_of(bytes));
    }
    return py::bytes(merged);
  });
  m.def("identify_factors", &identify_factors);
}

}  // namespace veridyn::python
