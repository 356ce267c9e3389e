#include "host/shared_memory.h"

#include <sys/mman.h>

#include <new>

namespace metabuffer {

SharedMemory::SharedMemory(std::size_t bytes)
    : bytes_(bytes), begin_(mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0)) {
    if (begin_ == MAP_FAILED) throw std::bad_alloc();
}

SharedMemory::~SharedMemory() { munmap(begin_, bytes_); }

}  // namespace metabuffer
