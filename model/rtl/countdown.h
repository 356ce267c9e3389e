#pragma once

#include <string>

#include "rtl/register.h"

namespace metabuffer::rtl {

/// Clocks still to pass, in a register.
class Countdown {
  public:
    Countdown(RegisterSet& set, const std::string& name, int most_cycles, int reset_cycles = 0)
        : left_(set, name, bits_for(most_cycles), reset_cycles) {}

    void start(int cycles) { left_ = cycles; }
    bool running() const { return left_ > 0; }
    int left() const { return left_; }
    /// A clock passes. False: none was left.
    bool pass() {
        if (!running()) return false;
        --left_;
        return true;
    }

  private:
    Register<int> left_;
};

}  // namespace metabuffer::rtl
