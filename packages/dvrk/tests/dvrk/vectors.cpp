#include "dvrk/vectors.hpp"

// Section 19 of the firmware I/O specification: whole UDP payloads, captured between the
// laboratory's host software and a responder that it accepts.

namespace veridyn::dvrk {

// clang-format off
const std::vector<Vector>& vectors() {
  static const std::vector<Vector> kVectors = {
    {"19.1", "PC to all", Direction::kToBoard, 8,
     "0100ffff0400ffd000000000000b0100007f11c036d8"},
    {"19.1", "PC to all", Direction::kToBoard, 8,
     "0100ffff0840ffd000000000000458ffb182"},
    {"19.1", "reply", Direction::kToHost, 8,
     "ffd00860ffc0000000000000514c4131000000000003000001900384"},
    {"19.1", "PC to all", Direction::kToBoard, 8,
     "0103ffff0c00ffd000000000000100000000f099894f"},
    {"19.1", "PC to all", Direction::kToBoard, 8,
     "0103ffff1040ffd000000000000073785972"},
    {"19.1", "reply", Direction::kToHost, 8,
     "ffd01060ffc000000000000046b00000000000000003000001900384"},
    {"19.1", "PC to all", Direction::kToBoard, 8,
     "0103ffff1440ffd000000000000766ffb385"},
    {"19.1", "reply", Direction::kToHost, 8,
     "ffd01460ffc000000000000000000008000000000003000001900384"},
    {"19.1", "PC to all", Direction::kToBoard, 8,
     "0103ffff1840ffd000000000000c51f5b7f2"},
    {"19.1", "reply", Direction::kToHost, 8,
     "ffd01860ffc0000000000000a01c0000000000000003000001900384"},
    {"19.2", "PC to board", Direction::kToBoard, 8,
     "0003ffc13c40ffd00000000000001d3f5ddb"},
    {"19.2", "board to PC", Direction::kToHost, 8,
     "ffd03c60ffc100000000000047b00000000000000003000001900384"},
    {"19.3", "watchdog 0.3 s (57600 ticks) to board 6", Direction::kToBoard, 8,
     "0003ffc0b000ffd00000000000030000e1006b1e45f3"},
    {"19.3", "encoder 1 preload +1000, board 6", Direction::kToBoard, 8,
     "0003ffc0b400ffd0000000000014008003e8445dd2e4"},
    {"19.3", "safety relay close, board 6", Direction::kToBoard, 8,
     "0003ffc0d800ffd000000000000000030000d8fe55ba"},
    {"19.3", "QLA PROM read command (3 quadlets from 0)", Direction::kToBoard, 8,
     "0003ffc08800ffd0000000003000fe00000287400e34"},
    {"19.3", "PHY request 1, FireWire broadcast", Direction::kToBoard, 8,
     "0003ffff7c00ffd000000000000100000001f5f24d2b"},
    {"19.4", "PC to board", Direction::kToBoard, 8,
     "0003ffc08c50ffd0000000003100000c0000b0380825"},
    {"19.4", "board to PC", Direction::kToHost, 8,
     "ffd08c70ffc0000000000000000c000000000000514c4120313233342d3536ff000000000003000001900384"},
    {"19.5", "power on, board 6", Direction::kToBoard, 8,
     "0003ffc0e010ffd000000000000000180000fda62e130000060600000000000000000000000000000000000c"
     "0000b96f4a65"},
    {"19.5", "amps on + zero current, board 6", Direction::kToBoard, 8,
     "0003ffc0f010ffd00000000000000018000091deb4df00000606b0008000b0008000b0008000b00080000000"
     "00005335d276"},
    {"19.5", "currents 0x8010.. , board 6", Direction::kToBoard, 8,
     "0003ffc00010ffd000000000000000180000fef39db500000606800080108000802080008030800080400000"
     "0000daf9e54f"},
    {"19.5", "currents 0x8010.. , board 7", Direction::kToBoard, 8,
     "0003ffc10410ffd00000000000000018000038e25a7400000706800080108000802080008030800080400000"
     "0000297b52bd"},
    {"19.5", "amps off, board 6", Direction::kToBoard, 8,
     "0003ffc01010ffd000000000000000180000928b077900000606200000002000000020000000200000000000"
     "00006a8195f9"},
    {"19.5", "power off, board 6", Direction::kToBoard, 8,
     "0003ffc01810ffd000000000000000180000a4b74a1f00000606000000000000000000000000000000000008"
     "0000be0df879"},
    {"19.6", "PC to board", Direction::kToBoard, 8,
     "0003ffc00850ffd000000000000000800000e57b051d"},
    {"19.6", "board to PC", Direction::kToHost, 8,
     "ffd00870ffc00000000000000080000000000000000025b8463f0f0f00000111000032348000801081008020"
     "8200803083008040108003e8108007d010800bb810800fa04800c0008bffffff8bffffff8bffffff60003000"
     "83ffffff83ffffff83ffffff6000300083ffffff83ffffff83ffffff4000006483ffffff83ffffff83ffffff"
     "30108010301080203010803030108040000000000003000001900384"},
    {"19.7", "1 query", Direction::kToBoard, 8,
     "0003ffffd000ffd0000000001800000300c013885d02"},
    {"19.7", "2 hub read", Direction::kToBoard, 8,
     "0003ffc0d450ffd0000000001000010c0000f058b71e"},
    {"19.7", "hub reply", Direction::kToHost, 8,
     "ffd0d470ffc0000000000000010c000000000000210301900001b64f463f0f0f000001110000323480008000"
     "810080008200800083008000108003e8108007d010800bb810800fa04800c0008bffffff8bffffff8bffffff"
     "6000300083ffffff83ffffff83ffffff6000300083ffffff83ffffff83ffffff4000006483ffffff83ffffff"
     "83ffffff30108000301080003010800030108000210302bc0001b384473f0f0f000001110000323480008000"
     "810080008200800083008000108003e8108007d010800bb810800fa04800c0008bffffff8bffffff8bffffff"
     "6000300083ffffff83ffffff83ffffff6000300083ffffff83ffffff83ffffff4000006483ffffff83ffffff"
     "83ffffff3010800030108000301080003010800007d00898000000000003000001900384"},
    {"19.7", "3 write all", Direction::kToBoard, 8,
     "0003ffffd810ffd00000000000000030000085024c4900000606800080108000802080008030800080400000"
     "00000000070680008010800080208000803080008040000000009e559872"},
    {"19.8", "power on board 6", Direction::kToBoard, 7,
     "0003ffc0c010ffd0000000000000001400002cf0cdaf06000000060000000600000006000000000c00002cf3"
     "42a3"},
    {"19.8", "amps on, board 6", Direction::kToBoard, 7,
     "0003ffc0d010ffd000000000000000140000408857638600800086008000860080008600800000000f0ff40c"
     "d741"},
    {"19.8", "amps on, board 7", Direction::kToBoard, 7,
     "0003ffc1d410ffd000000000000000140000869990a28700800087008000870080008700800000000f0fb3ee"
     "d861"},
    {"19.8", "currents board 6", Direction::kToBoard, 7,
     "0003ffc0e010ffd000000000000000140000f401f83786008010860080208600803086008040000000004f65"
     "ed89"},
    {"19.8", "RT read board 6", Direction::kToBoard, 7,
     "0003ffc0d850ffd000000000000000700000ee45233f"},
    {"19.8", "reply", Direction::kToHost, 7,
     "ffd0d870ffc000000000000000700000000000000001c207463f0f0f00000111000032348000800081008000"
     "8200800083008000008003e8008007d000800bb800800fa04800c0008bffffff8bffffff8bffffff60003000"
     "83ffffff83ffffff83ffffff6000300083ffffff83ffffff83ffffff4000006483ffffff83ffffff83ffffff"
     "000000000003000001900384"},
    {"19.8", "query", Direction::kToBoard, 7,
     "0003ffffd000ffd0000000001800000300c013885d02"},
    {"19.8", "hub read", Direction::kToBoard, 7,
     "0003ffc0d450ffd000000000100000ec00008d5ddf09"},
    {"19.8", "reply", Direction::kToHost, 7,
     "ffd0d470ffc000000000000000ec000000000000000301900001cca5463f0f0f000001110000323480008000"
     "810080008200800083008000008003e8008007d000800bb800800fa04800c0008bffffff8bffffff8bffffff"
     "6000300083ffffff83ffffff83ffffff6000300083ffffff83ffffff83ffffff4000006483ffffff83ffffff"
     "83ffffff000302bc0001cbf6473f0f0f000001110000323480008000810080008200800083008000008003e8"
     "008007d000800bb800800fa04800c0008bffffff8bffffff8bffffff6000300083ffffff83ffffff83ffffff"
     "6000300083ffffff83ffffff83ffffff4000006483ffffff83ffffff83ffffff07d008980000000000030000"
     "01900384"},
    {"19.8", "broadcast write", Direction::kToBoard, 7,
     "0003ffffd810ffd000000000000000280000964de00186008010860080208600803086008040000000008700"
     "801087008020870080308700804000000000231d1433"},
    {"19.9", "write, silently lost", Direction::kToBoard, 8,
     "0003ffc11c10ffd00000000000000018000062a68dde00000706000000000000000000000000000000000008"
     "00004d8f4f8b"},
    {"19.9", "read", Direction::kToBoard, 8,
     "0003ffc02050ffd0000000000000008000000bb67de3"},
    {"19.9", "reply (8 bytes)", Direction::kToHost, 8,
     "0204000001900384"},
    {"19.10", "query", Direction::kToBoard, 9,
     "0103ffffbc00ffd0000000001800000300c0537875c8"},
    {"19.10", "unsolicited reply", Direction::kToHost, 9,
     "ffd0bc70ffc6000000000000010c000000000000210301900001ada8463f0f0f000001110000323480008000"
     "810080008200800083008000108003e8108007d010800bb810800fa04800c0008bffffff8bffffff8bffffff"
     "6000300083ffffff83ffffff83ffffff6000300083ffffff83ffffff83ffffff4000006483ffffff83ffffff"
     "83ffffff30108000301080003010800030108000210302bc0001ab46473f0f0f000001110000323480008000"
     "810080008200800083008000108003e8108007d010800bb810800fa04800c0008bffffff8bffffff8bffffff"
     "6000300083ffffff83ffffff83ffffff6000300083ffffff83ffffff83ffffff4000006483ffffff83ffffff"
     "83ffffff3010800030108000301080003010800007d00898000000001003000001900384"},
    {"19.10", "write all", Direction::kToBoard, 9,
     "0103ffffb810ffd000000000000000300000e8d00f5600000606b0008000b0008000b0008000b00080000000"
     "000000000706b0008000b0008000b0008000b0008000000000001c404f4d"},
    {"19.10", "preload b6 to 127.0.0.7", Direction::kToBoard, 9,
     "0103ffc68400ffd0000000000014008003e8377601f2"},
    {"19.10", "preload b7 to 127.0.0.8", Direction::kToBoard, 9,
     "0103ffc79800ffd0000000000014008003e8ab231199"},
  };
  return kVectors;
}
// clang-format on

std::vector<std::uint8_t> bytes_of(const std::string& hex) {
  std::vector<std::uint8_t> bytes;
  for (size_t k = 0; k + 1 < hex.size(); k += 2)
    bytes.push_back(static_cast<std::uint8_t>(std::stoul(hex.substr(k, 2), nullptr, 16)));
  return bytes;
}

std::string hex_of(ByteView bytes) {
  static const char* const kDigits = "0123456789abcdef";
  std::string hex;
  for (size_t k = 0; k < bytes.size; ++k) {
    hex += kDigits[bytes.data[k] >> 4];
    hex += kDigits[bytes.data[k] & 0xF];
  }
  return hex;
}

const Vector& vector_named(const std::string& section, const std::string& name) {
  for (const Vector& v : vectors()) {
    if (v.section == section && v.name == name) return v;
  }
  throw std::runtime_error("no vector " + section + " " + name);
}

}  // namespace veridyn::dvrk
