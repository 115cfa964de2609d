#include "fuzz/targets.hpp"

#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "dvrk/arms/arm_facts.hpp"
#include "dvrk/arms/gravity_chain.hpp"
#include "dvrk/config/io_config.hpp"
#include "dvrk/packet_probe.hpp"
#include "dvrk/vectors.hpp"
#include "identification/synthetic_recording.hpp"
#include "model/mesh_file.hpp"
#include "recordings/bags/bag_probe.hpp"
#include "recordings/recording_probe.hpp"
#include "recordings/samples.hpp"
#include "support/file_in_memory.hpp"
#include "support/stranger_files.hpp"
#include "veridyn/calibration/capture.hpp"
#include "veridyn/control/load_cell.hpp"
#include "veridyn/cooperation/live.hpp"
#include "veridyn/cooperation/teleoperation_scenario.hpp"
#include "veridyn/identification/factor_set.hpp"
#include "veridyn/identification/fleet.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/model/model_file.hpp"
#include "veridyn/model/simulator_files.hpp"
#include "veridyn/model/urdf.hpp"

namespace veridyn {
namespace {

namespace fs = std::filesystem;
using Seeds = std::vector<std::string>;

constexpr std::size_t kLongestMessage = 4000;  // a line that a terminal still shows as a whole

// Files of this project below a folder, smaller than 200 kB, whose paths hold one of the words.
Seeds files(const std::string& folder, const std::vector<std::string>& words) {
  std::vector<std::string> paths;
  for (const fs::directory_entry& entry :
       fs::recursive_directory_iterator(VERIDYN_SOURCE_DIR "/" + folder)) {
    const std::string path = entry.path().string();
    if (!entry.is_regular_file() || entry.file_size() > 200000) continue;
    for (const std::string& word : words)
      if (path.find(word) != std::string::npos) {
        paths.push_back(path);
        break;
      }
  }
  std::sort(paths.begin(), paths.end());
  Seeds out;
  for (const std::string& path : paths) out.push_back(bytes_of_file(path));
  return out;
}

// Runs a reader. A refusal has to be one line.
template <typename Read>
std::string refusal_or(const Read& read) {
  try {
    return read();
  } catch (const InvalidInput& refused) {
    const std::string message = refused.what();
    if (message.empty()) return "a refusal without a word";
    if (message.size() > kLongestMessage) return "a refusal of " + text(message.size()) + " bytes";
    if (message.find('\n') != std::string::npos) return "a refusal of several lines: " + message;
    return "";
  }
}

// Degrees in files are radians here: numbers may differ in their last digit.
enum class Again { kSame, kAccepted };

// What a writer makes of an accepted input is accepted, and written the same again.
template <typename Write, typename Read>
std::string written_again(const Write& write, const Read& read, Again expected = Again::kSame) {
  const std::string first = write();
  try {
    const std::string second = read(first);
    if (expected == Again::kAccepted || second == first) return "";
    return "written differently the second time: " + first + "\n" + second;
  } catch (const InvalidInput& refused) {
    return std::string("refused what was written: ") + refused.what() + "\n" + first;
  }
}

std::string probe_robot(std::string_view bytes) {
  return refusal_or([&] {
    const Model arm = read_yaml(std::string(bytes), "robot.yaml");
    return written_again([&] { return to_yaml(arm); },
                         [](const std::string& out) { return to_yaml(read_yaml(out, "again.yaml")); });
  });
}

Seeds model_seeds() {
  const Model arm = read_model("planar-2r");
  MotionShape shape;
  shape.duration = 10.0;
  const std::string path = fs::temp_directory_path() / ("veridyn-fuzz-" + text(::getpid()) + ".csv");
  write_recording(synthetic_recording(arm, shape), path);
  const FactorSet factors = compress(arm, {path});
  Seeds out{to_yaml(identify(arm, factors).model.value()), to_bytes(factors)};
  fs::remove(path);
  return out;
}

std::string probe_urdf(std::string_view bytes) {
#ifdef VERIDYN_WITH_URDF
  const FileInMemory file(bytes);
  return refusal_or([&] {
    const Model arm = read_urdf(file.path());
    urdf_appearance(file.path());
    to_yaml(arm);
    return std::string();
  });
#else
  (void)bytes;
  return "";
#endif
}

Seeds urdf_seeds() {
  Seeds out = files("examples/own_robot", {".urdf"});
  for (const char* robot : {"planar-2r", "scara", "kuka-lwr4"}) out.push_back(to_urdf(read_model(robot)));
  return out;
}

template <Model (*kRead)(const std::string&)>
std::string probe_simulation(std::string_view bytes) {
  const FileInMemory file(bytes);
  return refusal_or([&] {
    to_yaml(kRead(file.path()));
    return std::string();
  });
}

std::string probe_signals(std::string_view bytes) {
  return refusal_or([&] {
    read_probe(bytes);
    return std::string();
  });
}

std::string probe_bag(std::string_view bytes) {
  const std::string_view start = bytes.substr(0, 6);
  if (start.substr(0, 4) == "#ROS" || start == "\x89MCAP0" || start == "SQLite" ||
      start.substr(0, 4) == "\x28\xB5\x2F\xFD")
    bags::probe_container(bytes);
  return probe_signals(bytes);
}

std::string probe_io_xml(std::string_view bytes) {
  return refusal_or([&] {
    const dvrk::IoConfig config = dvrk::read_io_xml(std::string(bytes), "io.xml");
    dvrk::to_io_json(config);
    return written_again([&] { return dvrk::to_io_xml(config); }, [](const std::string& out) {
      return dvrk::to_io_xml(dvrk::read_io_xml(out, "again.xml"));
    }, Again::kAccepted);
  });
}

std::string probe_io_json(std::string_view bytes) {
  return refusal_or([&] {
    const dvrk::IoConfig config = dvrk::read_io_json(std::string(bytes), "io.json");
    return written_again([&] { return dvrk::to_io_json(config); }, [](const std::string& out) {
      return dvrk::to_io_json(dvrk::read_io_json(out, "again.json"));
    }, Again::kAccepted);
  });
}

Seeds io_json_seeds() {
  Seeds out;
  for (const std::string& xml : files("data/dvrk", {".xml"}))
    out.push_back(dvrk::to_io_json(dvrk::read_io_xml(xml, "io.xml")));
  for (const char* arm : {"PSM1", "MTMR", "ECM"})
    out.push_back(dvrk::to_io_json(dvrk::nominal_config(dvrk::read_arm(arm))));
  return out;
}

Seeds io_xml_seeds() {
  Seeds out = files("data/dvrk", {".xml"});
  out.push_back(dvrk::to_io_xml(dvrk::nominal_config(dvrk::read_arm("MTMR"))));
  return out;
}

// read_arm() knows its files by their ending.
std::string probe_arm_facts(std::string_view bytes) {
  const std::string path = fs::temp_directory_path() / ("veridyn-fuzz-" + text(::getpid()) + ".yaml");
  std::ofstream(path, std::ios::binary) << bytes;
  const std::string wrong = refusal_or([&] {
    for (const char* arm : {"PSM1", "MTMR", "ECM"}) {
      const dvrk::ArmFacts facts = dvrk::read_arm(path + ":" + arm);
      dvrk::nominal_config(facts);
      dvrk::arm_model(facts);
    }
    return std::string();
  });
  fs::remove(path);
  return wrong;
}

std::string probe_static_torques(std::string_view bytes) {
  const FileInMemory file(bytes);
  return refusal_or([&] {
    const dvrk::StaticTorques read = dvrk::read_static_torques(file.path());
    return std::string(read.q.rows() == read.tau.rows() ? "" : "positions and efforts differ in rows");
  });
}

std::string probe_datagram(std::string_view bytes) {
  const char* wrong =
      dvrk::probe_packet({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
  return wrong == nullptr ? "" : wrong;
}

Seeds datagram_seeds() {
  Seeds out;
  for (const dvrk::Vector& v : dvrk::vectors()) {
    const std::vector<std::uint8_t> bytes = dvrk::bytes_of(v.hex);
    out.emplace_back(bytes.begin(), bytes.end());
  }
  return out;
}

template <LoadCellFormat format>
std::string probe_load_cell(std::string_view bytes) {
  LoadCellDecoder decoder(format);
  for (const char c : bytes)
    if (decoder.take(static_cast<std::uint8_t>(c)) && !std::isfinite(decoder.raw()))
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

std::string probe_capture(std::string_view bytes) {
  const FileInMemory file(bytes);
  const std::string wrong = refusal_or([&] {
    const MarkerCapture read = read_markers(file.path());
    read.bodies();
    return std::string();
  });
  if (!wrong.empty()) return wrong;
  return refusal_or([&] {
    const PoseCapture read = read_poses(file.path());
    return std::string(read.time.size() == read.frames() ? "" : "times and poses differ in number");
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

std::string probe_mesh(std::string_view bytes) {
  const FileInMemory file(bytes);
  return refusal_or([&] {
    const Mesh mesh = read_mesh(file.path());
    for (const std::array<int, 3>& triangle : mesh.triangles)
      for (const int corner : triangle)
        if (corner < 0 || corner >= static_cast<int>(mesh.points.size()))
          return std::string("a triangle of a point that is not there");
    return std::string();
  });
}

std::string probe_fleet(std::string_view bytes) {
  const FileInMemory file(bytes);
  return refusal_or([&] {
    read_fleet(file.path());
    return std::string();
  });
}

// The checksum is set right, or nothing behind it would be reached.
std::string probe_factors(std::string_view bytes) {
  constexpr std::size_t kHead = 32;  // magic word, version, checksum
  std::string whole(bytes);
  if (whole.size() > kHead) {
    std::uint64_t hash = 14695981039346656037ULL;
    for (std::size_t k = kHead; k < whole.size(); ++k)
      hash = (hash ^ static_cast<unsigned char>(whole[k])) * 1099511628211ULL;
    for (std::size_t k = 0; k < 8; ++k) whole[24 + k] = static_cast<char>(hash >> (8 * k));
  }
  return refusal_or([&] {
    const FactorSet read = factors_from_bytes(whole, "factors");
    return written_again([&] { return to_bytes(read); }, [](const std::string& out) {
      return to_bytes(factors_from_bytes(out, "again"));
    });
  });
}

}  // namespace

const std::vector<FuzzTarget>& fuzz_targets() {
  static const std::vector<FuzzTarget> all = {
      {"robot", probe_robot, [] { return files("data/robots", {".yaml"}); }},
      {"model", probe_robot, [] { return Seeds{model_seeds()[0]}; }},
      {"urdf", probe_urdf, urdf_seeds},
      {"mjcf", probe_simulation<read_mjcf>, [] { return Seeds{kStrangerMjcf}; }},
      {"sdf", probe_simulation<read_sdf>, [] { return Seeds{kStrangerSdf}; }},
      {"csv", probe_signals,
       [] {
         Seeds out = files("tests/recordings/samples", {".csv"});
         out.push_back("t;q1;q2;tau1;tau2\n0,00;0,10;0,20;1,0;2,0\n0,01;0,11;0,21;1,1;2,1\n");
         out.push_back("# t q1 q2\n0.00 0.10 0.20\n0.01 0.11 0.21\n0.02 0.12 0.22\n");
         out.push_back("\xEF\xBB\xBFtime_ms\tElbow pos [deg]\tElbow torque [mNm]\r\n0\t10\t1\r\n5\t11\t2\r\n");
         out.push_back("sec,nsec,q1,q2\n1700000000,0,0.1,0.2\n1700000000,5000000,0.1,0.3\n");
         return out;
       }},
      {"ros1", probe_bag, [] { return files("tests/recordings/samples", {".bag"}); }},
      {"mcap", probe_bag, [] { return files("tests/recordings/samples", {".mcap"}); }},
      {"db3", probe_bag, [] { return files("tests/recordings/samples", {".db3"}); }},
      {"npz", probe_signals, [] { return files("tests/recordings/samples", {".npz", ".npy"}); }},
      {"mat", probe_signals, [] { return files("tests/recordings/samples", {"matlab5.mat"}); }},
      {"hdf5", probe_signals, [] { return files("tests/recordings/samples", {".h5", "matlab73.mat"}); }},
      {"io_xml", probe_io_xml, io_xml_seeds},
      {"io_json", probe_io_json, io_json_seeds},
      {"arm_facts", probe_arm_facts, [] { return files("data/dvrk", {".yaml"}); }},
      {"static_torques", probe_static_torques,
       [] { return Seeds{"q1,q2,tau1,tau2\n0.1,0.2,1,2\n0.2,0.3,1.5,2.5\n", "0.1 0.2 1 2\n0.2 0.3 1 2\n"}; }},
      {"datagram", probe_datagram, datagram_seeds},
      {"load_cell_text", probe_load_cell<LoadCellFormat::kText>,
       [] { return Seeds{"8388607\n0.1,512\r\nHX711 reading: 8388607\nraw=-12.5e3\n"}; }},
      {"load_cell_frames", probe_load_cell<LoadCellFormat::kBinary>, frame_seeds},
      {"load_cell_file", probe_load_cell_file,
       [] {
         return Seeds{load_cell_text(calibrate_load_cell({0, 0, 1, 1, 2, 2}, {10, 11, 110, 112, 209, 211}))};
       }},
      {"capture", probe_capture,
       [] {
         return Seeds{
             "t,a/1/x,a/1/y,a/1/z,a/2/x,a/2/y,a/2/z,a/3/x,a/3/y,a/3/z\n0,0,0,0,1,0,0,0,1,0\n0.1,0,0,0.1,1,0,0.1,0,1,0.1\n",
             "t,x,y,z,qw,qx,qy,qz\n0,0,0,0,1,0,0,0\n0.1,1,2,3,0.7,0.7,0,0\n",
             "t,q1,q2,x,y,z\n0,0.1,0.2,1,2,3\n0.1,0.2,0.3,1,2,3\n",
             "t,body,marker,x [mm],y [mm],z [mm]\n0,a,1,0,0,0\n0,a,2,1,0,0\n0,a,3,0,1,0\n",
             "t,a/x,a/y,a/z,a/qw,a/qx,a/qy,a/qz\n0,0,0,0,1,0,0,0\n",
             "Format Version,1.23,Take Name,t\n\n,,Rigid Body,Rigid Body\n,,a,a\n,,1,1\n,,Position,Position\nFrame,Time (Seconds),X,Y\n0,0,1,2\n",
             "Trajectories\n100\n,,a:1,,\nFrame,Sub Frame,X,Y,Z\n,,mm,mm,mm\n1,0,1,2,3\n2,0,1,2,3\n",
             "NO_OF_FRAMES\t2\nNO_OF_MARKERS\t1\nFREQUENCY\t100\nMARKER_NAMES\ta1\n1\t2\t3\n1\t2\t3\n"};
       }},
      {"scenario", probe_scenario, [] { return files("examples", {"cooperate/"}); }},
      {"teleoperation", probe_teleoperation, [] { return files("examples/dvrk", {"teleoperation"}); }},
      {"live", probe_live,
       [] {
         return Seeds{"move 0.01 0 -0.02 1.5\nturn 0 0 0.1 1\njog 0.01 0 0\nforce spring 5 1\ntighten 0.001 1\n"
                      "arm left 0 0 0.01 1\nrelease spring\ntake spring\nstop\nalive\nwait 1\n# x\nquit\n"};
       }},
      {"mesh", probe_mesh,
       [] {
         return Seeds{"solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
                      "endloop\nendfacet\nendsolid s\n",
                      "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf -3//1 -2//1 -1//1\n",
                      std::string(80, ' ') + std::string("\x01\0\0\0", 4) + std::string(50, '\0')};
       }},
      {"fleet", probe_fleet, [] { return Seeds{"a,recording.csv\nb,x.csv\nb,y.csv\n# remark\n"}; }},
      {"factors", probe_factors, [] { return Seeds{model_seeds()[1]}; }},
  };
  return all;
}

}  // namespace veridyn
