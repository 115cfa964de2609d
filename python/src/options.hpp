#pragma once

#include <pybind11/pybind11.h>

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "interruptible.hpp"
#include "veridyn/diagnosis/diagnosis.hpp"
#include "veridyn/identification/identification.hpp"
#include "veridyn/recordings/recording_list.hpp"

namespace veridyn::python {

/// Keyword arguments by name, each taken once: what is left over in the end is a mistake.
class Keywords {
 public:
  Keywords(std::string function, const py::dict& given);

  /// Whether that name was given and not taken yet.
  bool given(const std::string& name) const { return left_.count(name) != 0; }

  /// The value of that name, or null where it was not given or is None.
  py::object value_of(const std::string& name);

  /// Sets `target` if the keyword was given.
  template <typename T>
  void read(const std::string& name, T& target) {
    const py::object value = value_of(name);
    if (value) target = convert<T>(name, value);
  }

  /// One of some words, each with its meaning.
  template <typename E, typename Name>
  void read_choice(const std::string& name, E& target, const std::vector<E>& choices,
                   const Name& name_of_choice) {
    const py::object value = value_of(name);
    if (!value) return;
    const std::string word = convert<std::string>(name, value);
    std::vector<std::string> words;
    for (const E choice : choices) {
      words.push_back(name_of_choice(choice));
      if (words.back() == word) {
        target = choice;
        return;
      }
    }
    refuse(name, word, words);
  }

  /// @throws py::type_error  an unused keyword, with a suggestion.
  void expect_all_taken() const;

  const std::string& function() const { return function_; }

 private:
  template <typename T>
  T convert(const std::string& name, const py::object& value) const {
    try {
      return value.cast<T>();
    } catch (const py::cast_error&) {
      refuse_type(name, value);
    }
  }
  [[noreturn]] void refuse(const std::string& name, const std::string& found,
                           const std::vector<std::string>& expected) const;
  [[noreturn]] void refuse_type(const std::string& name, const py::object& value) const;

  std::string function_;
  std::map<std::string, py::object> left_;
  std::vector<std::string> asked_;
};

/// Recordings as Python gives them: a path, a Recording, a pandas frame, anything with an attribute
/// `recording` or `motion`, or a list of such. Those in memory are shared, not copied.
Recordings recordings_of(const py::object& given);

/// From its path or bare name, or the Model itself.
Model model_of(const py::object& given);

/// topic, map, units: as the options of the command; a dictionary or "q=deg,t=ms" for the last two.
void read_signals(Keywords& keywords, SignalChoice& signals);

/// The keyword `fix`, positions by joint: the arm with these joints where they are. [rad], [m]
Model with_fix(Keywords& keywords, const Model& arm);

/// filter_cutoff, filter_order, filtering, velocity, stale_rows, resample, drop_start, drop_end,
/// min_speed, decimation, rows, columns, rate, topic, map, units.
void read_preprocessing(Keywords& keywords, PreprocessingOptions& options);

/// method, weights, condition, signs, prior, known_mass, threads, test_rows and those above.
/// `progress` is handed on; its stop ends the reading of recordings.
IdentificationOptions read_identification(Keywords& keywords, const Progress& progress,
                                          IdentificationOptions options = {});

}  // namespace veridyn::python
