#pragma once

#include <filesystem>
#include <string>

namespace metabuffer {

/// That this process alone writes something: a lock on a file of its own, which goes with the process however it ends.
class WriterLock {
  public:
    /// what: that which is written, as complaints name it; instead: what else to do. Throws InputError if another process
    /// holds the lock, with that one's number, or the file cannot be made.
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
