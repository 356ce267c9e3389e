#pragma once

#include <cstdint>
#include <ostream>
#include <string>
#include <systemc>

#include "rtl/signals.h"

/// The values that the wires inside an output framebuffer carry.
namespace metabuffer::rtl {

/// 0xRRGGBB.
constexpr int kDisplayColourBits = 24;

/// A display pixel on its way into the display's memory.
struct DisplayWrite {
    bool bank = false;  ///< which of the two
    std::uint32_t address = 0;
    std::uint32_t colour = 0;  ///< 0xRRGGBB
};
inline bool operator==(const DisplayWrite& a, const DisplayWrite& b) {
    return a.bank == b.bank && a.address == b.address && a.colour == b.colour;
}
std::ostream& operator<<(std::ostream& out, const DisplayWrite& value);
void sc_trace(sc_core::sc_trace_file* file, const DisplayWrite& value, const std::string& name,
              int address_bits = kNumberBits);

/// The display pixel that the memory is to put out.
struct DisplayRead {
    bool bank = false;
    std::uint32_t address = 0;
};
inline bool operator==(const DisplayRead& a, const DisplayRead& b) {
    return a.bank == b.bank && a.address == b.address;
}
std::ostream& operator<<(std::ostream& out, const DisplayRead& value);
void sc_trace(sc_core::sc_trace_file* file, const DisplayRead& value, const std::string& name,
              int address_bits = kNumberBits);

}  // namespace metabuffer::rtl
