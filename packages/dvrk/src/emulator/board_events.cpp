#include "emulator/board_events.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "dvrk/protocol/analog.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

struct Target {
  int place = -1;
  int axis = -1;
  double value = 0.0;
  bool has_value = false;
};

enum class Needs { kNothing, kBoard, kAxis };

struct EventKind {
  const char* name;
  Needs needs;
  const char* value;  ///< text after '='; nullptr: none
  const char* help;
  std::function<void(BoardEmulator&, const Target&)> happen;
};

BoardFaults& of(BoardEmulator& emulator, const Target& at) {
  return emulator.board(at.place).faults;
}

std::size_t axis(const Target& at) {
  return static_cast<std::size_t>(at.axis);
}

// Corrupts the next N replies ("=N"), or all of them.
EventKind reply(const char* name, ReplyFault fault, const char* help) {
  return {name, Needs::kNothing, "[N]", help, [fault](BoardEmulator& e, const Target& at) {
            e.faults.reply = fault;
            e.faults.replies = at.has_value ? static_cast<int>(at.value) : -1;
          }};
}

// Removes all faults of boards, encoders, replies and supply.
void repair(BoardEmulator& e) {
  e.faults = EmulatorFaults();
  e.chain.emergency_stop = false;
  e.chain.supply_on = true;
  for (int b = 0; b < e.boards(); ++b) {
    e.board(b).faults = BoardFaults();
    e.board(b).temperatures = 0x3234;
    for (int c = 0; c < kChannels; ++c)
      e.board(b).encoder(c).broken_lines = e.board(b).encoder(c).overflow_latched =
          e.board(b).encoder(c).stuck = false;
  }
}

std::vector<EventKind> world_kinds() {
  using E = BoardEmulator;
  using T = Target;
  return {
      {"emergency-stop", Needs::kNothing, nullptr, "the safety chain opens",
       [](E& e, const T&) { e.chain.emergency_stop = true; }},
      {"release", Needs::kNothing, nullptr, "it closes again",
       [](E& e, const T&) { e.chain.emergency_stop = false; }},
      {"supply-off", Needs::kNothing, nullptr, "the motor supply goes off",
       [](E& e, const T&) { e.chain.supply_on = false; }},
      {"supply-on", Needs::kNothing, nullptr, "and on",
       [](E& e, const T&) { e.chain.supply_on = true; }},
      {"bus-reset", Needs::kNothing, "[SECONDS]", "the generation counts up; silence for so long",
       [](E& e, const T& at) { e.bus_reset(at.value); }},
      {"lose-writes", Needs::kNothing, nullptr, "no write arrives any more",
       [](E& e, const T&) { e.faults.lose_writes = true; }},
      {"repair", Needs::kNothing, nullptr, "every fault is gone",
       [](E& e, const T&) { repair(e); }},
      {"loss", Needs::kNothing, "PERCENT", "of all datagrams are lost from then on, each way",
       [](E& e, const T& at) { e.faults.loss = 0.01 * at.value; }},
      {"late", Needs::kNothing, "SECONDS", "replies come so late",
       [](E& e, const T& at) {
         e.faults.reply = ReplyFault::kDelay;
         e.faults.replies = -1;
         e.faults.delay = at.value;
       }},
      reply("silence", ReplyFault::kDrop, "replies are lost"),
      reply("old", ReplyFault::kOld, "blocks of the hub repeat the first of them"),
      reply("short", ReplyFault::kTruncate, "replies lack four bytes"),
      reply("long", ReplyFault::kExtend, "replies have four bytes too many"),
      reply("wrong-label", ReplyFault::kLabel, "replies to another request"),
      reply("wrong-node", ReplyFault::kNode, "replies from another node"),
      reply("wrong-length", ReplyFault::kLength, "replies whose length field is wrong"),
      reply("wrong-crc", ReplyFault::kCrc, "replies with a wrong CRC"),
      reply("foreign", ReplyFault::kForeign, "replies from another address"),
  };
}

std::vector<EventKind> board_kinds() {
  using E = BoardEmulator;
  using T = Target;
  return {
      {"reboot", Needs::kBoard, nullptr, "it wakes up anew, the bus is reset",
       [](E& e, const T& at) { e.reboot(at.place); }},
      {"supply-fault", Needs::kBoard, nullptr, "its motor supply reports a fault",
       [](E& e, const T& at) { of(e, at).supply_fault = true; }},
      {"relay-open", Needs::kBoard, nullptr, "its safety relay stays open",
       [](E& e, const T& at) { of(e, at).relay_stuck_open = true; }},
      {"encoder-supply", Needs::kBoard, nullptr, "its encoders lose their supply",
       [](E& e, const T& at) { of(e, at).encoder_supply = true; }},
      {"ignore-writes", Needs::kBoard, nullptr, "it ignores real-time writes",
       [](E& e, const T& at) { of(e, at).ignores_writes = true; }},
      {"stop-clock", Needs::kBoard, nullptr, "its timestamps are zero",
       [](E& e, const T& at) { of(e, at).stops_clock = true; }},
      {"skip-query", Needs::kBoard, nullptr, "it never answers a broadcast query",
       [](E& e, const T& at) { of(e, at).skips_query = true; }},
      {"wrong-id", Needs::kBoard, "ID", "its status shows another board",
       [](E& e, const T& at) { of(e, at).wrong_id = static_cast<int>(at.value) & 15; }},
      {"warm", Needs::kBoard, "CELSIUS", "its first sensor measures so much",
       [](E& e, const T& at) {
         const double half = std::clamp(2.0 * at.value, 0.0, 254.0);
         e.board(at.place).temperatures = (static_cast<std::uint32_t>(half) << 8) | 0x34;
       }},
  };
}

std::vector<EventKind> axis_kinds() {
  using E = BoardEmulator;
  using T = Target;
  return {
      {"amp-fault", Needs::kAxis, nullptr, "its amplifier fails",
       [](E& e, const T& at) { of(e, at).amp[axis(at)] = true; }},
      {"current", Needs::kAxis, "AMPERE", "so much is added to its measured current",
       [](E& e, const T& at) {
         of(e, at).current[axis(at)] =
             static_cast<std::int32_t>(std::lround(at.value * kNominalAmpsToBits.scale));
       }},
      {"encoder-error", Needs::kAxis, nullptr, "its encoder makes illegal transitions",
       [](E& e, const T& at) { e.board(at.place).encoder(at.axis).broken_lines = true; }},
      {"encoder-jump", Needs::kAxis, "COUNTS", "its counter jumps by so many",
       [](E& e, const T& at) { e.board(at.place).encoder(at.axis).slip(std::llround(at.value)); }},
      {"encoder-stuck", Needs::kAxis, nullptr, "its counter stands still, whatever its shaft does",
       [](E& e, const T& at) { e.board(at.place).encoder(at.axis).stuck = true; }},
      {"encoder-overflow", Needs::kAxis, nullptr, "its counter has run over",
       [](E& e, const T& at) { e.board(at.place).encoder(at.axis).overflow_latched = true; }},
      {"pot-wire", Needs::kAxis, nullptr, "its pot reads zero",
       [](E& e, const T& at) { of(e, at).pot_wire[axis(at)] = true; }},
      {"pot-shift", Needs::kAxis, "VOLT", "so much is added to its pot",
       [](E& e, const T& at) {
         of(e, at).pot[axis(at)] = at.value / kNominalBitsToVolts.scale;
       }},
  };
}

const std::vector<EventKind>& kinds() {
  static const std::vector<EventKind> kAll = [] {
    std::vector<EventKind> all = world_kinds();
    for (const auto& more : {board_kinds(), axis_kinds()})
      all.insert(all.end(), more.begin(), more.end());
    return all;
  }();
  return kAll;
}

std::string form_of(const EventKind& kind) {
  std::string form = kind.name;
  if (kind.needs == Needs::kBoard) form += ":BOARD";
  if (kind.needs == Needs::kAxis) form += ":BOARD.AXIS";
  if (kind.value != nullptr) {
    const bool may = kind.value[0] == '[';
    form += may ? "[=" + std::string(kind.value + 1) : "=" + std::string(kind.value);
  }
  return form + "@S";
}

// Throws InvalidInput.
[[noreturn]] void refuse(const std::string& words, const std::string& expected) {
  throw InvalidInput("found '" + words + "', expected " + expected);
}

// Parses the whole of `text` as a number.
bool number(const std::string& text, double& value) {
  int used = 0;
  return std::sscanf(text.c_str(), "%lf%n", &value, &used) == 1 &&
         used == static_cast<int>(text.size()) && std::isfinite(value);
}

// Parses the whole of `text` as an integer of at most 1e6 in magnitude; false: it is none.
bool whole_number(const std::string& text, int& value) {
  double real = 0.0;
  if (!number(text, real) || real != std::floor(real) || std::abs(real) > 1e6) return false;
  value = static_cast<int>(real);
  return true;
}

// Index of the board with this id. @throws InvalidInput  it is not emulated.
int place_of(BoardEmulator& emulator, int id) {
  for (int b = 0; b < emulator.boards(); ++b) {
    if (emulator.board(b).setup().id == id) return b;
  }
  throw InvalidInput(text("board ", id, " is not emulated"));
}

// Parses BOARD or BOARD.AXIS and the value of an event of this kind. @throws InvalidInput  another form.
Target target_of(const std::string& words, const std::string& where, const std::string& value,
                 const EventKind& kind, BoardEmulator& emulator) {
  Target at;
  int board = -1;
  const auto dot = where.find('.');
  bool right = where.empty() == (kind.needs == Needs::kNothing);
  if (kind.needs == Needs::kBoard) right = right && whole_number(where, board);
  if (kind.needs == Needs::kAxis)
    right = right && dot != std::string::npos && whole_number(where.substr(0, dot), board) &&
            whole_number(where.substr(dot + 1), at.axis) && at.axis >= 0 &&
            at.axis < kChannels;
  at.has_value = !value.empty();
  if (at.has_value) right = right && kind.value != nullptr && number(value, at.value);
  if (!at.has_value) right = right && (kind.value == nullptr || kind.value[0] == '[');
  if (!right) refuse(words, form_of(kind));
  if (kind.needs != Needs::kNothing) at.place = place_of(emulator, board);
  return at;
}

// Parses "NAME[:BOARD[.AXIS]][=VALUE]@SECONDS". @throws InvalidInput  another form.
BoardEvent event_of(const std::string& words, BoardEmulator& emulator) {
  BoardEvent event;
  const auto at = words.rfind('@');
  event.words = words.substr(0, at);
  const auto equals = event.words.find('=');
  const auto colon = event.words.substr(0, equals).find(':');
  const std::string name = event.words.substr(0, std::min(equals, colon));
  const bool timed =
      at != std::string::npos && number(words.substr(at + 1), event.time) && event.time >= 0.0;
  const auto kind = std::find_if(kinds().begin(), kinds().end(),
                                 [&](const EventKind& one) { return name == one.name; });
  if (kind == kinds().end() || !timed) {
    std::string names;
    for (const EventKind& one : kinds()) names += std::string(names.empty() ? "" : ", ") + one.name;
    refuse(words, "EVENT@S with one of: " + names);
  }
  const std::string where =
      colon == std::string::npos
          ? ""
          : event.words.substr(colon + 1,
                               equals == std::string::npos ? equals : equals - colon - 1);
  const std::string value = equals == std::string::npos ? "" : event.words.substr(equals + 1);
  const Target target = target_of(words, where, value, *kind, emulator);
  event.happen = [happen = kind->happen, target](BoardEmulator& e) { happen(e, target); };
  return event;
}

}  // namespace

std::vector<BoardEvent> board_events(const std::vector<std::string>& words,
                                     BoardEmulator& emulator) {
  std::vector<BoardEvent> events;
  for (const std::string& one : words) events.push_back(event_of(one, emulator));
  std::stable_sort(events.begin(), events.end(),
                   [](const BoardEvent& a, const BoardEvent& b) { return a.time < b.time; });
  return events;
}

std::string board_event_help() {
  std::string help = "Events of --event, with the time in seconds since the start:\n";
  for (const EventKind& kind : kinds()) {
    std::string form = form_of(kind);
    form.resize(std::max<std::size_t>(form.size() + 1, 34), ' ');
    help += "  " + form + kind.help + "\n";
  }
  return help;
}

}  // namespace veridyn::dvrk
