#pragma once

#include <cstddef>

namespace metabuffer {

/// Memory that this process shares with the children that it forks later.
class SharedMemory {
  public:
    /// Throws std::bad_alloc.
    explicit SharedMemory(std::size_t bytes);
    SharedMemory(const SharedMemory&) = delete;
    SharedMemory& operator=(const SharedMemory&) = delete;
    ~SharedMemory();

    void* begin() const { return begin_; }

  private:
    std::size_t bytes_;
    void* begin_;
};

}  // namespace metabuffer
