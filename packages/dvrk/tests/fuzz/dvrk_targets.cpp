#include "fuzz/probe.hpp"

#include "dvrk/arms/arm_facts.hpp"
#include "dvrk/arms/gravity_chain.hpp"
#include "dvrk/config/io_config.hpp"
#include "dvrk/packet_probe.hpp"
#include "dvrk/vectors.hpp"

namespace veridyn {
namespace {

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

const AddFuzzTargets kTargets({
    {"io_xml", probe_io_xml, io_xml_seeds},
    {"io_json", probe_io_json, io_json_seeds},
    {"arm_facts", probe_arm_facts, [] { return files("data/dvrk", {".yaml"}); }},
    {"static_torques", probe_static_torques,
     [] { return Seeds{"q1,q2,tau1,tau2\n0.1,0.2,1,2\n0.2,0.3,1.5,2.5\n", "0.1 0.2 1 2\n0.2 0.3 1 2\n"}; }},
    {"datagram", probe_datagram, datagram_seeds},
});

}  // namespace
}  // namespace veridyn
