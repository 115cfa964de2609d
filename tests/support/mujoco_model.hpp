#pragma once

#include <mujoco/mujoco.h>

#include <cstring>
#include <memory>
#include <string>

#include "veridyn/math/require.hpp"

namespace veridyn {

/// What MuJoCo makes of a file's text. @throws InvalidInput with MuJoCo's words.
struct MujocoModel {
  struct Free {
    void operator()(mjModel* m) const { mj_deleteModel(m); }
    void operator()(mjData* d) const { mj_deleteData(d); }
  };

  explicit MujocoModel(const std::string& xml) {
    const auto files = std::make_unique<mjVFS>();
    mj_defaultVFS(files.get());
    mj_makeEmptyFileVFS(files.get(), "arm.xml", static_cast<int>(xml.size()));
    std::memcpy(files->filedata[0], xml.data(), xml.size());
    char error[1000] = "";
    model.reset(mj_loadXML("arm.xml", files.get(), error, sizeof(error)));
    mj_deleteVFS(files.get());
    require(model != nullptr, error, "\n", xml);
    data.reset(mj_makeData(model.get()));
  }

  std::unique_ptr<mjModel, Free> model;
  std::unique_ptr<mjData, Free> data;
};

}  // namespace veridyn
