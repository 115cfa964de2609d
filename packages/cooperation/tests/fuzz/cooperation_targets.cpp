#include "fuzz/probe.hpp"

#include <cmath>
#include <sstream>

#include "veridyn/control/load_cell.hpp"
#include "veridyn/cooperation/live.hpp"
#include "veridyn/cooperation/teleoperation_scenario.hpp"

namespace veridyn {
namespace {

template <LoadCellFormat format>
std::string probe_load_cell(std::string_view bytes) {
  LoadCellDecoder decoder(format);
  for (const char c : bytes)
    if (decoder.add_byte(static_cast<std::uint8_t>(c)) && !std::isfinite(decoder.raw()))
      return "a reading that is no number";
  return "";
}

Seeds frame_seeds() {
  std::string stream;
  for (const int raw : {0, 1, -8388608, 8388607}) {
    std::string body;
    body += '\x01';
    body += '\0';
    for (int shift = 0; shift < 32; shift += 8)
      body += static_cast<char>(static_cast<std::uint32_t>(raw) >> shift);
    const std::uint16_t crc = crc16(reinterpret_cast<const std::uint8_t*>(body.data()), 6);
    stream += "\xA5\x5A" + body + static_cast<char>(crc) + static_cast<char>(crc >> 8);
  }
  return {stream};
}

std::string probe_load_cell_file(std::string_view bytes) {
  const FileInMemory file(bytes);
  return refusal_or([&] {
    const LoadCellCalibration read = read_load_cell(file.path());
    return written_again([&] { return load_cell_text(read); }, [](const std::string& out) {
      return load_cell_text(read_load_cell(FileInMemory(out).path()));
    });
  });
}

std::string probe_scenario(std::string_view bytes) {
  return refusal_or([&] {
    Scenario read = parse_scenario(std::string(bytes), VERIDYN_SOURCE_DIR "/examples/cooperate/s.yaml");
    tune_force_laws(read);
    return std::string();
  });
}

std::string probe_teleoperation(std::string_view bytes) {
  const FileInMemory file(bytes);
  is_teleoperation(file.path());
  return refusal_or([&] {
    read_teleoperation(file.path());
    return std::string();
  });
}

std::string probe_live(std::string_view bytes) {
  static const Scenario scenario =
      read_scenario(VERIDYN_SOURCE_DIR "/examples/cooperate/two-arms-spring.yaml");
  std::istringstream lines{std::string(bytes)};
  for (std::string line; std::getline(lines, line);) {
    const std::string wrong = refusal_or([&] {
      parse_live_command(line, scenario);
      return std::string();
    });
    if (!wrong.empty()) return wrong;
  }
  return "";
}

const AddFuzzTargets kTargets({
    {"load_cell_text", probe_load_cell<LoadCellFormat::kText>,
     [] { return Seeds{"8388607\n0.1,512\r\nHX711 reading: 8388607\nraw=-12.5e3\n"}; }},
    {"load_cell_frames", probe_load_cell<LoadCellFormat::kBinary>, frame_seeds},
    {"load_cell_file", probe_load_cell_file,
     [] {
       return Seeds{load_cell_text(calibrate_load_cell({0, 0, 1, 1, 2, 2}, {10, 11, 110, 112, 209, 211}))};
     }},
    {"scenario", probe_scenario, [] { return files("examples", {"cooperate/"}); }},
    {"teleoperation", probe_teleoperation, [] { return files("examples/dvrk", {"teleoperation"}); }},
    {"live", probe_live,
     [] {
       return Seeds{"move 0.01 0 -0.02 1.5\nturn 0 0 0.1 1\njog 0.01 0 0\nforce spring 5 1\ntighten 0.001 1\n"
                    "arm left 0 0 0.01 1\nrelease spring\ntake spring\nstop\nalive\nwait 1\n# x\nquit\n"};
     }},
});

}  // namespace
}  // namespace veridyn
