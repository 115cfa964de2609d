#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>

// A part of every test program: each process has a temporary folder of its own, so that files of tests that run
// side by side never meet, whatever their names.

namespace veridyn {
namespace {

class OwnTemporaryFolder {
 public:
  OwnTemporaryFolder() {
    std::string path = (std::filesystem::temp_directory_path() / "veridyn-test-XXXXXX").string();
    if (::mkdtemp(path.data()) == nullptr) return;
    path_ = path;
    for (const char* name : {"TMPDIR", "TEST_TMPDIR"}) ::setenv(name, path.c_str(), 1);
  }
  ~OwnTemporaryFolder() {
    std::error_code ignored;
    if (::getpid() == owner_) std::filesystem::remove_all(path_, ignored);  // not at the end of a fork
  }
  OwnTemporaryFolder(const OwnTemporaryFolder&) = delete;
  OwnTemporaryFolder& operator=(const OwnTemporaryFolder&) = delete;

 private:
  std::string path_;
  pid_t owner_ = ::getpid();
};

const OwnTemporaryFolder kFolder;

}  // namespace
}  // namespace veridyn
