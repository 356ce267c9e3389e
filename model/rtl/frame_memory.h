#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "formats/control_scanline.h"
#include "formats/pixel.h"
#include "rtl/block.h"

namespace metabuffer::rtl {

/// The 64-bit page-mode memory of an input framebuffer (sections 4 and 5.2 of the paper): two banks of one
/// pixel a word. The link writes the back bank, colour half and depth half of each word on their own; the bus
/// reads the front bank.
///
/// Timing of the read side, in core clocks: up to words_per_cycle words of the open page in each clock; a
/// word of another page first costs page_miss_cycles clocks. A new frame finds no page open. The block has no
/// clock of its own: its input framebuffer, whose registers surround it, calls it at its clock edges. The
/// write side belongs to the link's clock and never touches the front bank, so the two do not disturb each
/// other.
class FrameMemory final : public Block {
  public:
    /// words: pixels of one image.
    FrameMemory(const sc_core::sc_module_name& name, const MemoryConfig& config, DepthFormat depth_format,
                std::int64_t words);

    // ---- the link's side ----
    void write_half(FrameKind half, std::uint32_t address, std::uint32_t link_bits);
    /// The back bank becomes the front one.
    void swap_banks();

    // ---- the bus's side ----
    void close_page() { open_page_ = kNoPage; }
    bool page_is_open(std::int64_t address) const { return address / config_.page_words == open_page_; }
    /// Opens the address's page; the caller lets page_miss_cycles() clocks pass before it reads.
    void open_page(std::int64_t address) { open_page_ = address / config_.page_words; }
    int words_per_cycle() const { return config_.words_per_cycle; }
    int page_miss_cycles() const { return config_.page_miss_cycles; }
    /// A word of the open page. Raises /metabuffer/frame_memory/page if its page is not open.
    Pixel read(std::int64_t address) const;

    void trace(sc_core::sc_trace_file* file) const override;

  private:
    static constexpr std::int64_t kNoPage = -1;

    MemoryConfig config_;
    DepthFormat depth_format_;
    std::array<std::vector<Pixel>, 2> banks_;
    std::size_t front_ = 0;
    std::int64_t open_page_ = kNoPage;
};

}  // namespace metabuffer::rtl
