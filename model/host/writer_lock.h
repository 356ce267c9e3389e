#pragma once

#include <filesystem>
#include <string>

namespace metabuffer {

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

  private:
    [[noreturn]] void fail(int error) const;
    void take(const std::string& instead);
    bool is_in_place();

    std::filesystem::path lock_file_;
    std::string what_;
    int descriptor_ = -1;
};

}  // namespace metabuffer
