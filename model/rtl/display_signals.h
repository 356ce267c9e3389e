#pragma once

#include <cstdint>

#include "rtl/fields.h"

/// The values that the wires inside an output framebuffer carry.
namespace metabuffer::rtl {

/// 0xRRGGBB.
constexpr int kDisplayColourBits = 24;

/// A display pixel on its way into the display's memory.
struct DisplayWrite {
    bool picture = false;  ///< which of the two in the memory; "bank" in the waveform
    std::uint32_t address = 0;
    std::uint32_t colour = 0;  ///< 0xRRGGBB

    template <typename See>
    static void visit_fields(const See& see, int address_bits = kAllBits) {
        see("bank", &DisplayWrite::picture);
        see("address", &DisplayWrite::address, address_bits);
        see("colour", &DisplayWrite::colour, kDisplayColourBits);
    }
};

/// The display pixel that the memory is to put out.
struct DisplayRead {
    bool picture = false;  ///< as in DisplayWrite
    std::uint32_t address = 0;

    template <typename See>
    static void visit_fields(const See& see, int address_bits = kAllBits) {
        see("bank", &DisplayRead::picture);
        see("address", &DisplayRead::address, address_bits);
    }
};

}  // namespace metabuffer::rtl
