#pragma once

#include <cstdint>
#include <string>

#include "rtl/register.h"

namespace metabuffer::rtl {

/// A bank of page-mode memory, in registers: which page is open.
class MemoryBank {
  public:
    MemoryBank(RegisterSet& set, const std::string& name, int page_bits)
        : open_(set, name + "_open"), page_(set, name + "_page", page_bits) {}

    bool is_open() const { return open_; }
    bool is_open(std::uint32_t page) const { return open_ && page_ == page; }
    /// The page that is open, or was last.
    std::uint32_t page() const { return page_; }
    void open(std::uint32_t page) {
        open_ = true;
        page_ = page;
    }
    void close() { open_ = false; }

  private:
    Register<bool> open_;
    Register<std::uint32_t> page_;
};

}  // namespace metabuffer::rtl
