#include "fuzz/probe.hpp"

#include <unistd.h>

#include <filesystem>

#include "identification/synthetic_recording.hpp"
#include "files/mesh_file.hpp"
#include "recordings/bags/bag_probe.hpp"
#include "recordings/recording_probe.hpp"
#include "recordings/samples.hpp"
#include "support/stranger_files.hpp"
#include "veridyn/identification/factor_set.hpp"
#include "veridyn/identification/fleet.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/files/simulator_files.hpp"
#include "veridyn/files/urdf.hpp"

namespace veridyn {
namespace {


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
  const FileInMemory file(bytes);
  return refusal_or([&] {
    const Model arm = read_urdf(file.path());
    urdf_appearance(file.path());
    to_yaml(arm);
    return std::string();
  });
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

std::vector<FuzzTarget>& registered() {
  static std::vector<FuzzTarget> all;
  return all;
}

}  // namespace

const std::vector<FuzzTarget>& fuzz_targets() {
  return registered();
}

AddFuzzTargets::AddFuzzTargets(const std::vector<FuzzTarget>& targets) {
  registered().insert(registered().end(), targets.begin(), targets.end());
}

const AddFuzzTargets kLibrary({
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
      {"mesh", probe_mesh,
       [] {
         return Seeds{"solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
                      "endloop\nendfacet\nendsolid s\n",
                      "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf -3//1 -2//1 -1//1\n",
                      std::string(80, ' ') + std::string("\x01\0\0\0", 4) + std::string(50, '\0')};
       }},
      {"fleet", probe_fleet, [] { return Seeds{"a,recording.csv\nb,x.csv\nb,y.csv\n# remark\n"}; }},
      {"factors", probe_factors, [] { return Seeds{model_seeds()[1]}; }},
});

}  // namespace veridyn
