#include "rtl/frame_memory.h"

namespace metabuffer::rtl {

FrameMemory::FrameMemory(const sc_core::sc_module_name& name, const MemoryConfig& config,
                         DepthFormat depth_format, std::int64_t words)
    : Block(name), config_(config), depth_format_(depth_format) {
    for (std::vector<Pixel>& bank : banks_) {
        bank.resize(static_cast<std::size_t>(words));
    }
}

void FrameMemory::write_half(FrameKind half, std::uint32_t address, std::uint32_t link_bits) {
    Pixel& word = banks_[1 - front_][address];
    word = half == FrameKind::kColour ? with_colour_half(word, link_bits)
                                      : with_depth_half(word, link_bits, depth_format_);
}

void FrameMemory::swap_banks() { front_ = 1 - front_; }

Pixel FrameMemory::read(std::int64_t address) const {
    if (!page_is_open(address)) {
        SC_REPORT_ERROR("/metabuffer/frame_memory/page",
                        ("word " + std::to_string(address) + " read while page " +
                         std::to_string(open_page_) + " was open")
                            .c_str());
    }
    return banks_[front_][static_cast<std::size_t>(address)];
}

void FrameMemory::trace(sc_core::sc_trace_file* file) const {
    sc_core::sc_trace(file, open_page_, path("open_page"));
    sc_core::sc_trace(file, front_, path("front_bank"), 1);
}

}  // namespace metabuffer::rtl
