#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <iostream>
#include <memory>

#include "cli/commands.hpp"
#include "cli/identification/live_page.hpp"
#include "veridyn/tool/common_options.hpp"
#include "files/output_file.hpp"
#include "veridyn/tool/messages.hpp"
#include "veridyn/tool/option_checks.hpp"
#include "tool/recording_options.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/recordings/growing_recording.hpp"
#include "veridyn/recordings/preprocessing.hpp"
#include "veridyn/report/watch_json.hpp"

namespace veridyn::cli {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kRowsAtOnce = 200;
constexpr std::chrono::seconds kPageEvery{2};
constexpr size_t kMostStates = 200000;  // number of states kept for the page: more than five hours of steps
// A message warns if the residual exceeds the share kDoubtful of a joint's torque, or kSmall and also kWorse
// times the share in the model's own recordings.
constexpr double kDoubtful = 0.5, kWorse = 3.0, kSmall = 0.05;

volatile std::sig_atomic_t interrupted = 0;

void stop(int /*signal*/) { interrupted = 1; }

// Sets the handlers of the signals that end the program: `handler`, after which results are still written, or
// the default.
void on_signals(void (*handler)(int)) {
  struct sigaction action {};  // SA_RESTART is not set, so that a signal ends a blocking read
  action.sa_handler = handler;
  ::sigaction(SIGINT, &action, nullptr);
  ::sigaction(SIGTERM, &action, nullptr);
}

struct WatchRequest {
  std::string model;
  std::vector<std::string> sources, learn_from;
  bool follow = false, json_lines = false;
  double idle = 0.0;
  std::optional<int> port;  // port of --serve; 0: any
  WatchOptions options;
  PreprocessingOptions reading;
  CommonOptions common;
};

// True if a source is a recording that is still being written.
bool has_growing_source(const WatchRequest& request) {
  return request.follow ||
         std::find(request.sources.begin(), request.sources.end(), "-") != request.sources.end();
}

// Watches one source after the other and collects data for reports.
class Watching {
 public:
  Watching(const Model& arm, WatchRequest& request, const std::string& command_line)
      : arm_(arm), request_(request), command_line_(command_line) {
    if (!has_growing_source(request)) progress_ = progress(request.common);
    if (!request.port) return;
    live_ = std::make_unique<LivePage>(*request.port);
    print_message(text("the page is at http://127.0.0.1:", live_->port(), "/"));
  }

  ExitStatus run() {
    for (const std::string& source : request_.sources) {
      if (interrupted != 0) break;
      Watch watch(arm_, request_.options);
      on_signals(SIG_DFL);
      for (const std::string& quiet : request_.learn_from) {
        show_progress("learning: " + quiet);
        watch.learn(read_recording(quiet, recording_options_for(arm_, request_.reading)));
      }
      on_signals(stop);
      watched_.push_back({});
      set_back_ = 0.0;
      watched_.back().source = source;
      watch.on_step([this](const WatchState& state) { store_state(state); });
      if (source == "-" || request_.follow) {
        follow_source(watch, source);
      } else {
        watch_file(watch, source);
      }
      print_events(watch.finish());
      note_blindness(watch);
      for (const std::string& remark : watch.remarks()) print_message(source + ": " + remark);
      warn_of_residual(source);
    }
    if (progress_) clear_bar();
    write_results(false);
    // Ctrl-C is the normal end of a growing source; it leaves a complete recording unfinished.
    if (interrupted != 0 && !has_growing_source(request_)) return kInterrupted;
    for (const WatchedSource& s : watched_) {
      if (!s.states.empty() && s.learned < s.to - s.from - s.blind - 0.5 * request_.options.step) continue;
      print_message(text(s.source, ": found ", s.to - s.from, " s, expected more than the ",
               request_.options.learn, " s in which noise is learned (--learn)."));
      return kDataCannotAnswer;
    }
    return kDone;
  }

 private:
  void show_progress(const std::string& what) const {
    if (progress_) progress_(what, static_cast<double>(watched_.size()) / static_cast<double>(request_.sources.size() + 1));
  }

  // Warns of a large residual while the noise is learned, because it then counts as normal for this arm.
  void warn_of_residual(const std::string& source) {
    const auto& identified = arm_.description().identified;
    const VectorXd own = identified && identified->error.size() == missed_.size() ? VectorXd(100.0 * identified->error) : VectorXd();
    VectorXd shares(missed_.size());
    bool wrong = false;
    for (Eigen::Index i = 0; i < missed_.size(); ++i) {
      const double share = std::sqrt(missed_[i] / std::max(measured_[i], 1e-12));
      shares[i] = 100.0 * share;
      wrong = wrong || share > kDoubtful || (own.size() > 0 && share > kSmall && shares[i] > kWorse * own[i]);
    }
    missed_.resize(0);
    const auto list = [](const VectorXd& percents) {
      std::string out;
      for (const double p : percents) out += fmt::format("{}{:.{}f}", out.empty() ? "" : ", ", p, p < 1.0 ? 2 : p < 10.0 ? 1 : 0);
      return out;
    };
    if (wrong)
      print_message(fmt::format("warning: {}: the model leaves {} % of the joints' torques while noise is learned, {}: columns or units may be wrong (check), "
                                "it may be another arm's, or something changed before (diagnose); only what changes afterwards is reported.",
                                source, list(shares), own.size() > 0 ? list(own) + " % of the recordings that it is from" : "expected at most 50 %"));
  }

  void watch_file(Watch& watch, const std::string& source) {
    RecordingReader reader(source, recording_options_for(arm_, request_.reading));
    for (Recording rows = reader.next(kRowsAtOnce); rows.rows() > 0 && interrupted == 0;
         rows = reader.next(kRowsAtOnce)) {
      show_progress("watching: " + source);
      print_events(watch.add(rows));
    }
    for (const std::string& remark : reader.facts().remarks) print_message(source + ": " + remark);
  }

  // Shifts the source's beginning and end by the time by which its clock was set back.
  void follow_clock(const WatchState& state) {
    const double by = state.set_back - set_back_;
    set_back_ = state.set_back;
    watched_.back().from -= by;
    watched_.back().to -= by;
  }

  void note_blindness(const Watch& watch) {
    WatchedSource& s = watched_.back();
    follow_clock(watch.state());
    s.blind = watch.state().blind;
    if (s.blind > 0.0) s.to = std::max(s.to, watch.state().heard);
  }

  void follow_source(Watch& watch, const std::string& source) {
    auto heard = Clock::now();
    const auto go_on = [&] {
      const double silent = std::chrono::duration<double>(Clock::now() - heard).count();
      write_page_if_due();
      return interrupted == 0 && (request_.idle <= 0.0 || silent < request_.idle);
    };
    GrowingRecording rows(source, recording_options_for(arm_, request_.reading), go_on);
    for (Recording row = rows.next(1); row.rows() > 0 && interrupted == 0; row = rows.next(1)) {
      heard = Clock::now();
      print_events(watch.add(row));
      note_blindness(watch);
      write_page_if_due();
    }
  }

  void store_state(const WatchState& state) {
    follow_clock(state);
    WatchedSource& s = watched_.back();
    if (s.states.empty()) s.from = state.time - 0.5 * request_.options.step;
    s.to = state.time + 0.5 * request_.options.step;
    if (state.learning) {
      s.learned += request_.options.step;
      if (missed_.size() == 0) missed_ = measured_ = VectorXd::Zero(state.torque.size());
      missed_ += state.residual.cwiseAbs2();
      measured_ += state.torque.cwiseAbs2();
    }
    s.states.push_back(state);
    if (s.states.size() > kMostStates) s.states.erase(s.states.begin(), s.states.begin() + kMostStates / 2);
  }

  void print_events(const std::vector<WatchEvent>& events) {
    if (progress_ && !events.empty()) clear_bar();
    for (const WatchEvent& e : events) {
      watched_.back().events.push_back(e);
      if (request_.json_lines) {
        std::cout << json_line(e, watched_.back().source) << std::endl;
      } else {
        std::cout << watched_.back().source << ": " << e.sentence << std::endl;
      }
    }
  }

  void write_page_if_due() {
    if ((request_.common.report.empty() && !live_) || Clock::now() - written_ < kPageEvery) return;
    write_results(true);
    written_ = Clock::now();
  }

  void write_results(bool running) {
    if (!running && !request_.common.json.empty())
      write_file(request_.common.json, to_json(watched_, arm_, running));
    if (!request_.common.report.empty() || live_) {
      const std::string page = to_page(watched_, arm_, command_line_, running);
      if (!request_.common.report.empty()) write_file(request_.common.report, page);
      if (live_) live_->show(page);
    }
    if (running || request_.json_lines) return;
    for (const WatchedSource& s : watched_)
      std::cout << s.source << ": " << s.alarms() << (s.alarms() == 1 ? " change" : " changes") << " in "
                << std::round(10.0 * (s.to - s.from)) / 10.0 << " s, " << s.learned << " s of them learned from"
                << (s.blind > 0.0 ? text(", ", std::round(10.0 * s.blind) / 10.0, " s not watched") : "") << "\n";
  }

  const Model& arm_;
  WatchRequest& request_;
  std::string command_line_;
  Progress progress_;
  std::vector<WatchedSource> watched_;
  std::unique_ptr<LivePage> live_;
  VectorXd missed_, measured_;  // (n) sums of squares while noise is learned
  Clock::time_point written_{};
  double set_back_ = 0.0;  // [s] time by which the present source's clock was set back
};

ExitStatus run(WatchRequest& request, const std::string& command_line) {
  require_writable(request.common.json, request.common.report);
  const Model arm = read_robot(request.model, request.common);
  for (const EffectTerm& term : arm.arm_effects())
    print_message("warning: " + term.effect + " on the arm is left out here: what it does may be named as something else.");
  for (const std::string& link : request.options.links) expect_one_of("--link", link, frame_names(arm));
  return Watching(arm, request, command_line).run();
}

}  // namespace

void add_watch_command(CLI::App& tool, Outcome& outcome) {
  const auto request = std::make_shared<WatchRequest>();
  CLI::App& command = *tool.add_subcommand(
      "watch", "Monitor a running arm: detect changes, isolate their cause, size it");
  command.add_option("MODEL", request->model, "Model file written by identify or diagnose")
      ->required();
  add_value(command, "SOURCE SOURCE...", request->sources,
            "Recordings, one after the other; - is standard input")
      ->required();
  command.add_flag("--follow", request->follow, "Wait for more samples of a file that grows");
  add_value(command, "--idle S", request->idle,
            "With --follow: end after so many seconds without a sample; 0: never",
            CLI::NonNegativeNumber);
  add_value(command, "--serve PORT", request->port,
            "Serve the live page at http://127.0.0.1:PORT; 0: any free port", CLI::Range(0, 65535));
  add_value(command, "--learn S", request->options.learn,
            "Duration of the fault-free beginning from which noise is learned [s]",
            CLI::PositiveNumber);
  add_value(command, "--learn-from REC...", request->learn_from,
            "Fault-free recordings of the same arm to learn noise from");
  add_value(command, "--false-alarms N", request->options.false_alarms,
            "Allowed rate of false alarms [1/h]", CLI::PositiveNumber);
  add_value(command, "--link FRAME...", request->options.links,
            "Links that may carry a load (default: all)");
  command.add_flag("--json-lines", request->json_lines,
                   "Print each event as a line of JSON on standard output");
  add_signal_options(command, request->reading.signals);
  add_robot_options(command, request->common);
  add_common_options(command, request->common);
  add_report_option(command, request->common);
  command.callback([request, &outcome, &command] {
    expect_prerequisites(command, {{"--idle", has_growing_source(*request), "--follow"}});
    request->options.learn_more = std::max(request->options.learn_more, request->options.learn);
    outcome.status = run(*request, outcome.command_line);
  });
}

}  // namespace veridyn::cli
