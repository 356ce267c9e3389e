#include "rtl/display_signals.h"

#include <iomanip>

namespace metabuffer::rtl {
std::ostream& operator<<(std::ostream& out, const DisplayWrite& value) {
    const auto flags = out.flags();
    out << "bank " << int{value.bank} << " address " << value.address << " colour 0x" << std::hex
        << value.colour;
    out.flags(flags);
    return out;
}

void sc_trace(sc_core::sc_trace_file* file, const DisplayWrite& value, const std::string& name,
              int address_bits) {
    sc_core::sc_trace(file, value.bank, name + ".bank");
    sc_core::sc_trace(file, value.address, name + ".address", address_bits);
    sc_core::sc_trace(file, value.colour, name + ".colour", kDisplayColourBits);
}

std::ostream& operator<<(std::ostream& out, const DisplayRead& value) {
    return out << "bank " << int{value.bank} << " address " << value.address;
}

void sc_trace(sc_core::sc_trace_file* file, const DisplayRead& value, const std::string& name,
              int address_bits) {
    sc_core::sc_trace(file, value.bank, name + ".bank");
    sc_core::sc_trace(file, value.address, name + ".address", address_bits);
}

}  // namespace metabuffer::rtl
