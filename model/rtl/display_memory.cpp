#include "rtl/display_memory.h"

#include <string>

namespace metabuffer::rtl {

DisplayMemory::DisplayMemory(const sc_core::sc_module_name& name, std::int64_t pixels) : Block(name) {
    for (std::vector<std::uint32_t>& picture : pictures_) {
        picture.resize(static_cast<std::size_t>(pixels));
    }
    write_clocked_.reads({writes_i, write_i});
    read_clocked_.reads({reset_i, reads_i, read_i});
}

void DisplayMemory::write_edge() {
    if (writes_i.read()) {
        write_clocked_.stay_awake();
        const DisplayWrite& write = write_i.read();
        at(write.picture, write.address, "write") = write.colour;
    }
}

void DisplayMemory::read_edge() {
    if (reads_i.read()) {
        read_clocked_.stay_awake();
        const DisplayRead& read = read_i.read();
        const DisplayWrite& write = write_i.read();
        const bool comes = writes_i.read() && write.picture == read.picture && write.address == read.address;
        data_o.write(comes ? write.colour : at(read.picture, read.address, "read"));
    }
}

std::uint32_t& DisplayMemory::at(bool picture, std::uint32_t address, const char* what) {
    std::vector<std::uint32_t>& pixels = pictures_[picture ? 1 : 0];
    if (address >= pixels.size()) {
        SC_REPORT_ERROR("/metabuffer/display_memory/address",
                        (std::string(name()) + " of " + std::to_string(pixels.size()) +
                         " pixels was asked to " + what + " address " + std::to_string(address))
                            .c_str());
        return pixels.front();
    }
    return pixels[address];
}

void DisplayMemory::trace(sc_core::sc_trace_file* file) const {
    sc_core::sc_trace(file, data_o.read(), path("data"), kDisplayColourBits);
}

}  // namespace metabuffer::rtl
