// Storage that fails on command: preloaded (LD_PRELOAD) into creepd, creep-worker and creepctl by the fault
// sweeps, it stands between them and every call that opens or changes a file under one folder. SQLite's calls
// go the same way.
//
// It counts these calls. At one of them the process is killed, or the call fails, or writes half of what it
// was given. It also records what was done, so that power_cut.py can say what a power cut at any moment would
// have left.
//
//   CREEP_FAULTS_ROOT     the folder; without it nothing happens
//   CREEP_FAULTS_PROGRAM  only calls of this program are counted (default: of all)
//   CREEP_FAULTS_KIND     kill | enospc | eio | short; with _AT
//   CREEP_FAULTS_AT       the fault strikes at this call, from 1
//   CREEP_FAULTS_READS    set: calls that only read count too
//   CREEP_FAULTS_MARK     file that is made when the fault strikes and says where; it strikes only once, in
//   one process CREEP_FAULTS_LASTS    set: enospc and eio go on, in every program, until MARK.lasts is
//   removed CREEP_FAULTS_CALLS    file to which the counted calls are written, "PROCESS CALL PATH" a line
//   CREEP_FAULTS_JOURNAL  file to which everything done is written (format: Journal below)
//
// Not seen: what is written through a memory map (SQLite's -shm, which recovery makes anew) and by stdio
// within libc (lines of stderr in worker.log).
#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <climits>
#include <cstdarg>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <string>
#include <string_view>

namespace {

// The real calls, past the names that this library takes over.
int real_open(const char* path, int flags, mode_t mode = 0) {
  return static_cast<int>(::syscall(SYS_openat, AT_FDCWD, path, flags | O_CLOEXEC, mode));
}

bool is_there(const std::string& path) { return ::syscall(SYS_faccessat, AT_FDCWD, path.c_str(), F_OK) == 0; }

void append(const std::string& path, std::string_view bytes) {
  const int file = real_open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0644);
  if (file < 0) return;
  ::syscall(SYS_write, file, bytes.data(), bytes.size());
  ::syscall(SYS_close, file);
}

std::string link_target(const std::string& link) {
  char target[PATH_MAX];
  const ssize_t size = ::syscall(SYS_readlink, link.c_str(), target, sizeof target);
  return size > 0 ? std::string(target, static_cast<std::size_t>(size)) : std::string();
}

std::string path_of(int descriptor) { return link_target("/proc/self/fd/" + std::to_string(descriptor)); }

/// Absolute, without "." and "//". Symbolic links are not looked at: the root is given without them.
std::string absolute(int directory, const char* path) {
  std::filesystem::path whole = path;
  if (whole.is_relative())
    whole = (directory == AT_FDCWD ? link_target("/proc/self/cwd") : path_of(directory)) / whole;
  std::string text = whole.lexically_normal().string();
  if (text.size() > 1 && text.back() == '/') text.pop_back();
  return text;
}

std::uint64_t inode_of(int descriptor) {
  struct stat about {};
  return ::fstat(descriptor, &about) == 0 ? about.st_ino : 0;
}

std::string environment(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? "" : value;
}

/// What was done, in the order in which it was done: one record a call that succeeded, all numbers
/// little-endian.
///
///   operation (1 byte), inode (8), offset or size (8), length of path, second path, data (4 each), these
///
/// C created a file, T its size was set, W data was written at the offset, S file or folder (D) was made
/// durable, R path was renamed to the second, L the second is a link to path, U unlinked, M folder made, X
/// folder removed.
class Journal {
 public:
  explicit Journal(const std::string& path)
      : file_(path.empty() ? -1 : real_open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0644)) {}

  bool open() const { return file_ >= 0; }

  /// Held from before a call until it is recorded, so that the records of all processes are in order.
  class Turn {
   public:
    explicit Turn(Journal& journal) : journal_(journal) {
      if (!journal_.open()) return;
      journal_.mutex_.lock();
      ::syscall(SYS_flock, journal_.file_, LOCK_EX);
    }
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;
    ~Turn() {
      if (!journal_.open()) return;
      ::syscall(SYS_flock, journal_.file_, LOCK_UN);
      journal_.mutex_.unlock();
    }

   private:
    Journal& journal_;
  };

  struct Record {
    char operation;
    std::string path;
    std::uint64_t inode = 0;
    std::uint64_t offset = 0;
    std::string second = {};
    std::string data = {};
  };
  void add(const Record& record) {
    std::string bytes(1, record.operation);
    put(bytes, record.inode, 8);
    put(bytes, record.offset, 8);
    for (const std::string* text : {&record.path, &record.second, &record.data}) put(bytes, text->size(), 4);
    bytes += record.path + record.second + record.data;
    ::syscall(SYS_write, file_, bytes.data(), bytes.size());
  }

 private:
  static void put(std::string& out, std::uint64_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) out.push_back(static_cast<char>((value >> (8 * i)) & 0xffu));
  }

  int file_;
  std::mutex mutex_;
};

class Injector {
 public:
  /// One for the process: the calls it stands in for have no other place to find it.
  static Injector& instance() {
    static Injector injector;
    return injector;
  }

  Journal& journal() { return journal_; }

  bool concerned(std::string_view path) const {
    return !root_.empty() && path.starts_with(root_) &&
           (path.size() == root_.size() || path[root_.size()] == '/');
  }

  /// 0: go on, with at most `size` bytes. Otherwise the error to fail with.
  int fault_at(const char* call, const std::string& path, bool changes, std::size_t& size) {
    // A full disk takes no more, but gives.
    const bool takes = changes && std::strcmp(call, "unlink") != 0 && std::strcmp(call, "rmdir") != 0;
    if (lasts_ && changes && is_there(mark_ + ".lasts")) return kind_ == "eio" ? EIO : takes ? ENOSPC : 0;
    if (!this_program_ || (!changes && !reads_)) return 0;
    const long number = ++counted_;
    const std::string line =
        std::string(call) + " " + path.substr(std::min(path.size(), root_.size() + 1)) + "\n";
    if (!calls_.empty()) append(calls_, std::to_string(::getpid()) + " " + line);
    if (number != strikes_at_ || !make_mark(line)) return 0;
    if (kind_ == "kill") ::kill(::getpid(), SIGKILL);
    if (kind_ == "eio") return EIO;
    // A disk that becomes full takes a part of the write that fills it.
    if (size > 1) {
      size /= 2;
      return 0;
    }
    return kind_ == "enospc" && takes ? ENOSPC : 0;
  }

 private:
  Injector()
      : root_(environment("CREEP_FAULTS_ROOT")),
        kind_(environment("CREEP_FAULTS_KIND")),
        mark_(environment("CREEP_FAULTS_MARK")),
        calls_(environment("CREEP_FAULTS_CALLS")),
        strikes_at_(std::atol(environment("CREEP_FAULTS_AT").c_str())),
        reads_(!environment("CREEP_FAULTS_READS").empty()),
        lasts_(!environment("CREEP_FAULTS_LASTS").empty()),
        journal_(environment("CREEP_FAULTS_JOURNAL")) {
    const std::string wanted = environment("CREEP_FAULTS_PROGRAM");
    this_program_ = wanted.empty() || link_target("/proc/self/exe").ends_with("/" + wanted);
  }

  bool make_mark(const std::string& line) const {
    const int file = real_open(mark_.c_str(), O_WRONLY | O_CREAT | O_EXCL, 0644);
    if (file < 0) return false;
    ::syscall(SYS_write, file, line.data(), line.size());
    ::syscall(SYS_close, file);
    if (lasts_) append(mark_ + ".lasts", "");
    return true;
  }

  const std::string root_;
  const std::string kind_;
  const std::string mark_;
  const std::string calls_;
  const long strikes_at_;
  const bool reads_;
  const bool lasts_;
  bool this_program_ = false;
  std::atomic<long> counted_ = 0;
  Journal journal_;
};

/// Lets `perform(size)` happen or fail, and has `describe(result)` recorded.
template <typename Perform, typename Describe>
long stand_in(const char* call, const std::string& path, bool changes, std::size_t size, Perform perform,
              Describe describe) {
  Injector& injector = Injector::instance();
  if (!injector.concerned(path)) return perform(size);
  if (const int error = injector.fault_at(call, path, changes, size); error != 0) {
    errno = error;
    return -1;
  }
  Journal& journal = injector.journal();
  if (!changes || !journal.open() || path.ends_with("-shm")) return perform(size);
  const Journal::Turn turn(journal);
  const long result = perform(size);
  const int error = errno;
  if (result >= 0) describe(journal, result);
  errno = error;
  return result;
}

int stand_in_for_open(int directory, const char* path, int flags, mode_t mode) {
  const std::string whole = absolute(directory, path);
  const bool existed = (flags & O_CREAT) == 0 || is_there(whole);
  const bool changes = !existed || (flags & O_TRUNC) != 0;
  return static_cast<int>(stand_in(
      "open", whole, changes, 0,
      [&](std::size_t) { return ::syscall(SYS_openat, directory, path, flags, mode); },
      [&](Journal& journal, long result) {
        const std::uint64_t inode = inode_of(static_cast<int>(result));
        if (!existed) journal.add({'C', whole, inode});
        if (existed) journal.add({'T', whole, inode});
      }));
}

mode_t mode_of(int flags, va_list arguments) {
  return (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(arguments, mode_t) : 0;
}

ssize_t stand_in_for_write(int descriptor, const void* bytes, std::size_t size, const off_t* place) {
  const std::string path = path_of(descriptor);
  return stand_in(
      place == nullptr ? "write" : "pwrite", path, true, size,
      [&](std::size_t allowed) {
        return place == nullptr ? ::syscall(SYS_write, descriptor, bytes, allowed)
                                : ::syscall(SYS_pwrite64, descriptor, bytes, allowed, *place);
      },
      [&](Journal& journal, long result) {
        // After the write, since only then is it known where an appending one went.
        const off_t end = ::lseek(descriptor, 0, SEEK_CUR);
        const auto offset = static_cast<std::uint64_t>(place == nullptr ? end - result : *place);
        const auto* const first = static_cast<const char*>(bytes);
        journal.add({'W', path, inode_of(descriptor), offset, "", std::string(first, first + result)});
      });
}

int stand_in_for_sync(const char* call, long number, int descriptor) {
  const std::string path = path_of(descriptor);
  return static_cast<int>(stand_in(
      call, path, true, 0, [&](std::size_t) { return ::syscall(number, descriptor); },
      [&](Journal& journal, long) {
        struct stat about {};
        const bool folder = ::fstat(descriptor, &about) == 0 && S_ISDIR(about.st_mode);
        journal.add({folder ? 'D' : 'S', path, about.st_ino});
      }));
}

int stand_in_for_truncate(int descriptor, off_t size) {
  const std::string path = path_of(descriptor);
  return static_cast<int>(stand_in(
      "ftruncate", path, true, 0, [&](std::size_t) { return ::syscall(SYS_ftruncate, descriptor, size); },
      [&](Journal& journal, long) {
        journal.add({'T', path, inode_of(descriptor), static_cast<std::uint64_t>(size)});
      }));
}

/// By its name, not by a descriptor.
int stand_in_for_truncate(const char* path, off_t size) {
  const std::string whole = absolute(AT_FDCWD, path);
  return static_cast<int>(stand_in(
      "truncate", whole, true, 0, [&](std::size_t) { return ::syscall(SYS_truncate, path, size); },
      [&](Journal& journal, long) {
        struct stat about {};
        if (::stat(path, &about) == 0)
          journal.add({'T', whole, about.st_ino, static_cast<std::uint64_t>(size)});
      }));
}

/// Returns the error instead of setting errno. Where a file system has no allocation of its own, libc writes
/// to every block; here the file then only gets its size, which is as far as a test can tell them apart.
int stand_in_for_allocate(int descriptor, off_t offset, off_t size) {
  const std::string path = path_of(descriptor);
  const int before = errno;
  const long result = stand_in(
      "posix_fallocate", path, true, 0,
      [&](std::size_t) -> long {
        const long allocated = ::syscall(SYS_fallocate, descriptor, 0, offset, size);
        if (allocated == 0 || errno != EOPNOTSUPP) return allocated;
        struct stat about {};
        if (::fstat(descriptor, &about) != 0 || about.st_size >= offset + size) return 0;
        return ::syscall(SYS_ftruncate, descriptor, offset + size);
      },
      [&](Journal& journal, long) {
        struct stat about {};
        if (::fstat(descriptor, &about) == 0)
          journal.add({'T', path, about.st_ino, static_cast<std::uint64_t>(about.st_size)});
      });
  const int error = result == 0 ? 0 : errno;
  errno = before;
  return error;
}

int stand_in_for_names(const char* call, char operation, const char* path, const char* second, long number) {
  const std::string whole = absolute(AT_FDCWD, path);
  const std::string whole_second = absolute(AT_FDCWD, second);
  return static_cast<int>(stand_in(
      call, whole_second, true, 0, [&](std::size_t) { return ::syscall(number, path, second); },
      [&](Journal& journal, long) {
        journal.add({operation, whole, 0, 0, whole_second});
      }));
}

template <typename Perform>
int stand_in_for_name(const char* call, char operation, int directory, const char* path, Perform perform) {
  const std::string whole = absolute(directory, path);
  return static_cast<int>(stand_in(
      call, whole, true, 0, [&](std::size_t) { return perform(); },
      [&](Journal& journal, long) {
        journal.add({operation, whole});
      }));
}

}  // namespace

// The names of libc. Those of 64-bit offsets are the same calls on x86-64.
extern "C" {

int open(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = mode_of(flags, arguments);
  va_end(arguments);
  return stand_in_for_open(AT_FDCWD, path, flags, mode);
}

int open64(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = mode_of(flags, arguments);
  va_end(arguments);
  return stand_in_for_open(AT_FDCWD, path, flags, mode);
}

int openat(int directory, const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = mode_of(flags, arguments);
  va_end(arguments);
  return stand_in_for_open(directory, path, flags, mode);
}

ssize_t read(int descriptor, void* bytes, size_t size) {
  return stand_in(
      "read", path_of(descriptor), false, 0,
      [&](std::size_t) { return ::syscall(SYS_read, descriptor, bytes, size); }, [](Journal&, long) {});
}

ssize_t pread(int descriptor, void* bytes, size_t size, off_t place) {
  return stand_in(
      "pread", path_of(descriptor), false, 0,
      [&](std::size_t) { return ::syscall(SYS_pread64, descriptor, bytes, size, place); },
      [](Journal&, long) {});
}

ssize_t pread64(int descriptor, void* bytes, size_t size, off64_t place) {
  return pread(descriptor, bytes, size, place);
}

ssize_t write(int descriptor, const void* bytes, size_t size) {
  return stand_in_for_write(descriptor, bytes, size, nullptr);
}

ssize_t pwrite(int descriptor, const void* bytes, size_t size, off_t place) {
  return stand_in_for_write(descriptor, bytes, size, &place);
}

ssize_t pwrite64(int descriptor, const void* bytes, size_t size, off64_t place) {
  return stand_in_for_write(descriptor, bytes, size, &place);
}

ssize_t writev(int descriptor, const struct iovec* pieces, int count) {
  if (!Injector::instance().concerned(path_of(descriptor)))
    return ::syscall(SYS_writev, descriptor, pieces, count);
  std::string bytes;
  for (int i = 0; i < count; ++i)
    bytes.append(static_cast<const char*>(pieces[i].iov_base), pieces[i].iov_len);
  return write(descriptor, bytes.data(), bytes.size());
}

int fsync(int descriptor) { return stand_in_for_sync("fsync", SYS_fsync, descriptor); }

int fdatasync(int descriptor) { return stand_in_for_sync("fdatasync", SYS_fdatasync, descriptor); }

int ftruncate(int descriptor, off_t size) noexcept { return stand_in_for_truncate(descriptor, size); }

int ftruncate64(int descriptor, off64_t size) noexcept { return stand_in_for_truncate(descriptor, size); }

int truncate(const char* path, off_t size) noexcept { return stand_in_for_truncate(path, size); }

int truncate64(const char* path, off64_t size) noexcept { return stand_in_for_truncate(path, size); }

int posix_fallocate(int descriptor, off_t offset, off_t size) {
  return stand_in_for_allocate(descriptor, offset, size);
}

int posix_fallocate64(int descriptor, off64_t offset, off64_t size) {
  return stand_in_for_allocate(descriptor, offset, size);
}

int rename(const char* path, const char* second) noexcept {
  return stand_in_for_names("rename", 'R', path, second, SYS_rename);
}

int link(const char* path, const char* second) noexcept {
  return stand_in_for_names("link", 'L', path, second, SYS_link);
}

int unlink(const char* path) noexcept {
  return stand_in_for_name("unlink", 'U', AT_FDCWD, path, [&] { return ::syscall(SYS_unlink, path); });
}

int rmdir(const char* path) noexcept {
  return stand_in_for_name("rmdir", 'X', AT_FDCWD, path, [&] { return ::syscall(SYS_rmdir, path); });
}

int unlinkat(int directory, const char* path, int flags) noexcept {
  const bool folder = (flags & AT_REMOVEDIR) != 0;
  return stand_in_for_name(folder ? "rmdir" : "unlink", folder ? 'X' : 'U', directory, path,
                           [&] { return ::syscall(SYS_unlinkat, directory, path, flags); });
}

int remove(const char* path) noexcept {
  const int result = unlink(path);
  return result != 0 && errno == EISDIR ? rmdir(path) : result;
}

int mkdir(const char* path, mode_t mode) noexcept {
  return stand_in_for_name("mkdir", 'M', AT_FDCWD, path, [&] { return ::syscall(SYS_mkdir, path, mode); });
}

}  // extern "C"
