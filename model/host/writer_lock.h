#pragma once

#include <filesystem>
#include <string>

namespace metabuffer {

/// Whether the file, which is there, lies on a file system that has no locks, such as NFS without its lock daemon. This
/// process loses the locks that it has on the file: ask only if something has failed.
bool lacks_locks(const std::filesystem::path& file);

/// Ensures that this process alone writes something: a lock on a separate file. It ends with the process, however that
/// ends.
class WriterLock {
  public:
    /// what: the name, in messages, of what is written; instead: what else to do. Throws InputError if another process
    /// holds the lock, with that process's number, or if the file cannot be made.
    WriterLock(const std::filesystem::path& lock_file, std::string what, const std::string& instead);
    WriterLock(const WriterLock&) = delete;
    WriterLock& operator=(const WriterLock&) = delete;
    ~WriterLock();

    /// False on a file system without locks: there every process may write.
    bool is_held() const { return is_held_; }

  private:
    [[noreturn]] void fail(int error) const;
    void take(const std::string& instead);
    bool is_in_place();

    std::filesystem::path lock_file_;
    std::string what_;
    int descriptor_ = -1;
    bool is_held_ = false;
};

}  // namespace metabuffer
