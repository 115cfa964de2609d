#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "veridyn/model/suggestion.hpp"

namespace veridyn::cli {

/// Adds an option whose value is one of several words: name_of(choice) of every choice.
template <typename T>
CLI::Option* add_choice(CLI::App& command, const std::string& option, T& target,
                        const std::vector<T>& choices, const std::string& help) {
  std::vector<std::string> words;
  for (const T& choice : choices) words.emplace_back(name_of(choice));
  const auto choose = [=, &target](const std::string& word) {
    for (const T& choice : choices) {
      if (word != name_of(choice)) continue;
      target = choice;
      return;
    }
    throw CLI::ValidationError(option, "found '" + word + "', expected one of " + listed(words) +
                                           did_you_mean(word, words));
  };
  std::string all;
  for (const std::string& word : words) all += (all.empty() ? "" : "|") + word;
  return command.add_option_function<std::string>(option, choose, help)
      ->option_text(all)
      ->default_str(name_of(target));
}

}  // namespace veridyn::cli
