#include "rtl/display_memory.h"

#include <string>

namespace metabuffer::rtl {

DisplayMemory::DisplayMemory(const sc_core::sc_module_name& name, std::int64_t pixels, ClockGating gating)
    : Block(name), write_gate_(gating), read_gate_(gating) {
    for (std::vector<std::uint32_t>& bank : banks_) {
        bank.resize(static_cast<std::size_t>(pixels));
    }
    SC_METHOD(write_edge);
    sensitive << clk_i.pos();
    dont_initialize();
    SC_METHOD(read_edge);
    sensitive << dvi_clk_i.pos();
    dont_initialize();
}

void DisplayMemory::end_of_elaboration() {
    write_gate_.attach(clk_i);
    read_wake_events_ |= reset_i.value_changed_event();
    read_wake_events_ |= reads_i.value_changed_event();
}

void DisplayMemory::write_edge() {
    if (write_gate_.opened()) {
        return;
    }
    const bool writes = writes_i.read();
    if (writes) {
        const DisplayWrite& write = write_i.read();
        at(write.bank, write.address, "write") = write.colour;
    }
    if (write_gate_.idle_edge(!writes)) {
        next_trigger(writes_i.value_changed_event());
    }
}

void DisplayMemory::read_edge() {
    if (read_gate_.opened()) {
        return;
    }
    const bool reset = reset_i.read();
    const bool reads = reads_i.read();
    if (reset) {
        data_o.write(0);
    } else if (reads) {
        const DisplayRead& read = read_i.read();
        const DisplayWrite& write = write_i.read();
        const bool comes = writes_i.read() && write.bank == read.bank && write.address == read.address;
        data_o.write(comes ? write.colour : at(read.bank, read.address, "read"));
    }
    if (read_gate_.idle_edge(!reset && !reads)) {
        next_trigger(read_wake_events_);
    }
}

std::uint32_t& DisplayMemory::at(bool bank, std::uint32_t address, const char* what) {
    std::vector<std::uint32_t>& pixels = banks_[bank ? 1 : 0];
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
