#include "rtl/frame_memory.h"

#include <catch2/catch.hpp>
#include <vector>

#include "expected_report.h"
#include "support/random_seed.h"

// The memory has no clock and no ports of its own: the input framebuffer's registers around it call it at
// their edges. What a page miss costs in clocks is tested at the input framebuffer's pins.
namespace metabuffer::test {
namespace {

using rtl::FrameMemory;

constexpr int kWords = 64;

MemoryConfig pages_of(int words, int miss_cycles = 6, int words_per_cycle = 1) {
    MemoryConfig config;
    config.page_words = words;
    config.page_miss_cycles = miss_cycles;
    config.words_per_cycle = words_per_cycle;
    return config;
}

Pixel word_at(FrameMemory& memory, std::int64_t address) {
    memory.open_page(address);
    return memory.read(address);
}

TEST_CASE("frame memory: colour half and depth half of a word are written on their own, in either order") {
    FrameMemory memory("memory", pages_of(16), DepthFormat::kA8Z16, kWords);
    memory.write_half(FrameKind::kColour, 3, 0x112233U);
    memory.write_half(FrameKind::kDepth, 3, 0x44BEEFU);
    memory.write_half(FrameKind::kDepth, 4, 0x55CAFEU);
    memory.write_half(FrameKind::kColour, 4, 0x667788U);
    memory.swap_banks();
    CHECK(word_at(memory, 3).word() == 0x0000'BEEF'4411'2233U);
    CHECK(word_at(memory, 4).word() == 0x0000'CAFE'5566'7788U);
    CHECK(word_at(memory, 5).word() == 0);
}

TEST_CASE("frame memory: z24 keeps 24 bits of Z and takes alpha as 255") {
    FrameMemory memory("memory", pages_of(16), DepthFormat::kZ24, kWords);
    memory.write_half(FrameKind::kColour, 0, 0x112233U);
    memory.write_half(FrameKind::kDepth, 0, 0xABCDEFU);
    memory.swap_banks();
    CHECK(word_at(memory, 0).word() == 0x00AB'CDEF'FF11'2233U);
}

TEST_CASE("frame memory: the bus reads the front bank while the link fills the back one") {
    FrameMemory memory("memory", pages_of(kWords), DepthFormat::kA8Z16, kWords);
    for (std::uint32_t address = 0; address < kWords; ++address) {
        memory.write_half(FrameKind::kColour, address, address);
    }
    memory.swap_banks();
    memory.open_page(0);
    for (std::uint32_t address = 0; address < kWords; ++address) {
        memory.write_half(FrameKind::kColour, address, 1000 + address);
        CHECK(memory.read(address).rgb() == address);
    }
    memory.swap_banks();
    CHECK(memory.read(7).rgb() == 1007);
    memory.swap_banks();
    CHECK(memory.read(7).rgb() == 7);  // the other bank has kept its pair
}

TEST_CASE("frame memory: one page is open at a time, of exactly page_words words") {
    for (const int page_words : {1, 7, 16, 64}) {
        INFO("pages of " << page_words << " words");
        FrameMemory memory(sc_core::sc_gen_unique_name("memory"), pages_of(page_words), DepthFormat::kA8Z16,
                           kWords);
        for (int opened = 0; opened < kWords; ++opened) {
            memory.open_page(opened);
            for (int address = 0; address < kWords; ++address) {
                const int first = opened - opened % page_words;
                const bool on_page = address >= first && address < first + page_words;
                REQUIRE(memory.page_is_open(address) == on_page);
            }
        }
    }
}

TEST_CASE("frame memory: no page is open at first nor after close_page") {
    FrameMemory memory("memory", pages_of(16), DepthFormat::kA8Z16, kWords);
    for (int address = 0; address < kWords; ++address) REQUIRE_FALSE(memory.page_is_open(address));
    memory.open_page(20);
    REQUIRE(memory.page_is_open(20));
    memory.close_page();
    for (int address = 0; address < kWords; ++address) REQUIRE_FALSE(memory.page_is_open(address));
}

TEST_CASE("frame memory: a read off the open page is reported") {
    FrameMemory memory("memory", pages_of(16), DepthFormat::kA8Z16, kWords);
    ExpectedReport report("/metabuffer/frame_memory/page");
    memory.open_page(16);
    memory.read(31);
    CHECK(report.count() == 0);
    memory.read(32);
    CHECK(report.count() == 1);
    memory.read(15);
    CHECK(report.count() == 2);
}

TEST_CASE("frame memory: its timing parameters are the scenario's") {
    const FrameMemory memory("memory", pages_of(16, 9, 4), DepthFormat::kA8Z16, kWords);
    CHECK(memory.page_miss_cycles() == 9);
    CHECK(memory.words_per_cycle() == 4);
}

}  // namespace
}  // namespace metabuffer::test
