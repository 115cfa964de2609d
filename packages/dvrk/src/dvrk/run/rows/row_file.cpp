#include "dvrk/run/rows/row_file.hpp"

#include <fcntl.h>
#include <sched.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <utility>

#include "veridyn/files/output_file.hpp"
#include "veridyn/recordings/remark.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

constexpr auto kPause = std::chrono::milliseconds(200);
constexpr int kSyncEvery = 5;               // pauses between two calls that bring rows to the disk
constexpr std::size_t kRemark = 200;        // bytes of the first line
constexpr Eigen::Index kMostAtOnce = 1000;  // rows in one piece of text

// A line that can be overwritten in place.
std::string remark_line(const std::string& remark) {
  std::string line = "# " + remark;
  line.resize(kRemark - 1, ' ');
  return line + "\n";
}

std::string header(Eigen::Index joints) {
  std::string line = "t";
  for (const char* name : {"q", "dq", "tau"}) {
    for (Eigen::Index j = 0; j < joints; ++j)
      line += "," + std::string(name) + std::to_string(j + 1);
  }
  return line + "\n";
}

// Appends a number with so many significant digits.
void add(double value, int digits, std::string& line) {
  char number[40];
  const auto end =
      std::to_chars(number, number + sizeof number, value, std::chars_format::general, digits);
  line.append(number, end.ptr);
}

}  // namespace

RowFile::RowFile(std::string path, const RowKeeper& rows, Eigen::Index joints)
    : path_(std::move(path)), keeper_(rows), joints_(joints) {
  struct stat there {};
  const bool exists = ::stat(path_.c_str(), &there) == 0;
  followed_ = !path_.empty() && (!exists || S_ISREG(there.st_mode));
  std::error_code ignored;
  if (followed_ && std::filesystem::is_symlink(path_, ignored))  // the link is kept, and its target replaced
    path_ = std::filesystem::weakly_canonical(path_, ignored).string();
  if (followed_) thread_ = std::thread([this] { follow(); });
}

RowFile::~RowFile() {
  stop();
  if (file_ >= 0) ::close(file_);
}

void RowFile::stop() {
  ends_ = true;
  if (thread_.joinable()) thread_.join();
}

// Opens the file at the first row only, so that a run without motion keeps an existing file, and under
// another name until that row is written, so that a full disk keeps it as well.
void RowFile::open() {
  constexpr int kNew = O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC;
  aside_ = text(path_, ".part-", ::getpid());
  file_ = ::open(aside_.c_str(), kNew, 0666);
  if (file_ < 0) {
    aside_.clear();
    file_ = ::open(path_.c_str(), kNew, 0666);
  }
  if (file_ < 0) {
    error_ = std::strerror(errno);
    failed_ = true;
    return;
  }
  put(remark_line("incomplete: the program ended while it recorded") + header(joints_));
}

// Gives the file its name after the first row, or removes it if there are no rows.
void RowFile::name_or_remove() {
  if (file_ < 0 || (written_ == 0 && !failed())) return;
  if (written_ > 0 && aside_.empty()) return;
  if (written_ > 0 && std::rename(aside_.c_str(), path_.c_str()) == 0) {
    aside_.clear();
    return;
  }
  if (written_ > 0) {
    error_ = std::strerror(errno);
    written_ = 0;
    failed_ = true;
  }
  ::unlink(aside_.empty() ? path_.c_str() : aside_.c_str());
  ::close(std::exchange(file_, -1));
}

bool RowFile::put(const std::string& bytes) {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t wrote = ::write(file_, bytes.data() + done, bytes.size() - done);
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote <= 0) {
      error_ = wrote < 0 ? std::strerror(errno) : "nothing more can be written";
      failed_ = true;
      return false;
    }
    done += static_cast<std::size_t>(wrote);
  }
  return true;
}

// Every call of write() contains whole rows, so that a killed program leaves no partial one. A full disk may
// truncate them; the file is then cut after the last whole row.
void RowFile::append() {
  const Recording& rows = keeper_.rows();
  const Eigen::Index count = keeper_.count();
  if (count > 0 && file_ < 0 && !failed()) open();
  while (written_ < count && !failed()) {
    const Eigen::Index last = std::min(count, written_ + kMostAtOnce);
    text_.clear();
    for (Eigen::Index k = written_; k < last; ++k) {
      add(rows.time[k], 15, text_);
      for (const MatrixXd* signal : {&rows.q, &rows.dq, &rows.tau}) {
        for (Eigen::Index j = 0; j < joints_; ++j) {
          text_ += ',';
          add((*signal)(k, j), 10, text_);
        }
      }
      text_ += '\n';
    }
    const off_t before = ::lseek(file_, 0, SEEK_CUR);
    if (put(text_)) {
      written_ = last;
      name_or_remove();
      continue;
    }
    const auto fitted = static_cast<std::size_t>(::lseek(file_, 0, SEEK_CUR) - before);
    const std::size_t whole = text_.rfind('\n', fitted == 0 ? 0 : fitted - 1);
    const std::size_t keep = fitted == 0 || whole == std::string::npos ? 0 : whole + 1;
    for (std::size_t k = 0; k < keep; ++k) written_ += text_[k] == '\n' ? 1 : 0;
    if (::ftruncate(file_, before + static_cast<off_t>(keep)) != 0) break;
  }
  name_or_remove();
}

void RowFile::follow() {
  sched_param ordinary{};
  ::sched_setscheduler(0, SCHED_OTHER, &ordinary);  // the inherited priority is that of the loop
  sigset_t all;
  ::sigfillset(&all);
  ::pthread_sigmask(SIG_BLOCK, &all, nullptr);
  for (int k = 1; !ends_ && !failed(); ++k) {
    append();
    if (file_ >= 0 && k % kSyncEvery == 0) ::fdatasync(file_);
    for (int part = 0; part < 10 && !ends_; ++part) std::this_thread::sleep_for(kPause / 10);
  }
}

void RowFile::remark_in_place(const std::string& remark) {
  std::string line = remark_line(remark);
  if (line.size() > kRemark) line = remark_line(remark.substr(0, kRemark - 3));
  if (file_ >= 0 && ::pwrite(file_, line.data(), line.size(), 0) < 0) error_ = std::strerror(errno);
}

// Copies the rows with another first line, without formatting them again.
void RowFile::copy_rows(const std::string& remark) const {
  std::ifstream rows(path_, std::ios::binary);
  rows.seekg(static_cast<std::streamoff>(kRemark));
  OutputFile whole(path_);
  if (!remark.empty()) whole.stream() << "# " << remark << '\n';
  whole.stream() << rows.rdbuf();
  require(rows.good() || rows.eof(), path_, ": cannot be read again.");
  whole.commit();
}

// Writes the final file in one piece; the file written during the run is kept if that fails, for example on a
// full disk.
void RowFile::finish(const std::string& remark) {
  if (path_.empty()) return;
  stop();
  if (followed_ && !failed()) append();
  if (followed_ && failed()) {
    remark_in_place("incomplete: " + error_ + " after " + std::to_string(written_) + " rows");
    return;
  }
  const Eigen::Index all = keeper_.count();
  if (all == 0) return;
  try {
    if (followed_)
      copy_rows(remark);
    else
      write_recording(keeper_.extract_rows(joints_), path_, remark);
    written_ = all;
  } catch (const std::exception& problem) {
    if (followed_) {
      remark_in_place(remark.empty() ? "complete" : remark);
    } else {
      error_ = problem.what();
    }
  }
}

}  // namespace veridyn::dvrk
