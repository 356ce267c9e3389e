#include "rtl/write_buffer.h"

#include <catch2/catch.hpp>
#include <vector>

#include "clocked_testbench.h"
#include "rtl/wires.h"

namespace metabuffer::test::write_buffer_test {
namespace {

using rtl::MemoryCommand;
using rtl::MemoryData;
using rtl::MemoryWrite;
using rtl::WriteBlock;
using rtl::WriteBuffer;

constexpr std::uint8_t kColour = MemoryWrite::kColourBytes;
constexpr std::uint8_t kDepth = MemoryWrite::kDepthBytes;

/// Blocks of 4 words of an image of 10, in pages of 8: the other image begins at word 16.
struct BufferBench {
    ClockDomain& core;
    sc_core::sc_signal<MemoryWrite> write;
    rtl::SignalBank<bool> full{WriteBuffer::kHalves, rtl::Wires::name_of("full")};
    rtl::SignalBank<WriteBlock> block{WriteBuffer::kHalves, rtl::Wires::name_of("block")};
    sc_core::sc_signal<MemoryCommand> command;
    sc_core::sc_signal<bool> drain;
    sc_core::sc_signal<MemoryData> data;
    WriteBuffer dut;
    std::vector<const Recording<bool>*> fulls, fulls_sampled;
    std::vector<const Recording<WriteBlock>*> blocks;
    const Recording<MemoryData>& sampled;

    explicit BufferBench(ClockedTestbench& bench)
        : core(bench.core), dut("write_buffer", config(), 10), sampled(core.record_sampled(data)) {
        dut.clk_i(core.clk);
        dut.reset_i(bench.reset);
        dut.write_i(write);
        dut.command_i(command);
        dut.drain_i(drain);
        dut.data_o(data);
        for (std::size_t half = 0; half < WriteBuffer::kHalves; ++half) {
            dut.full_o[half](full[half]);
            dut.block_o[half](block[half]);
            fulls.push_back(&core.record(full[half]));
            fulls_sampled.push_back(&core.record_sampled(full[half]));
            blocks.push_back(&core.record(block[half]));
        }
        bench.trace(dut);
    }
    static MemoryConfig config() {
        MemoryConfig config;
        config.page_words = 8;
        config.words_per_cycle = 2;
        config.ports = MemoryPorts::kShared;
        config.write_block_words = 4;
        return config;
    }
    /// Words of the link from edge `clock` on, one a clock, to `address` and those after it. A word is 100 more than
    /// its address.
    void bring(int clock, int device, int address, int words, std::uint8_t mask = kColour) {
        for (int word = address; word < address + words; ++word, ++clock) {
            core.drive(write, clock,
                       MemoryWrite{true, static_cast<std::uint8_t>(device), static_cast<std::uint32_t>(word),
                                   100U + static_cast<unsigned>(word), mask});
        }
        core.drive(write, clock, MemoryWrite{});
    }
    void ask(int clock, bool half, const std::vector<std::uint32_t>& columns) {
        MemoryCommand asked;
        asked.kind = MemoryCommand::Kind::kWrite;
        for (const std::uint32_t column : columns) asked.columns[asked.count++] = column;
        core.drive(drain, clock, half);
        core.drive(command, clock, asked);
        core.drive(command, clock + 1, MemoryCommand{});
    }
    std::vector<std::uint64_t> words_at(int clock) const {
        const MemoryData& put_out = sampled.at(clock);
        return {put_out.words.begin(), put_out.words.begin() + put_out.count};
    }
};

using Words = std::vector<std::uint64_t>;
using Clocks = std::vector<int>;

TEST_CASE("write buffer: a half is full with its block's last word, and then the other one fills") {
    ClockedTestbench bench;
    BufferBench dut(bench);
    dut.bring(2, 0, 0, 10);
    bench.run_through(14);
    CHECK(dut.fulls[0]->rises() == Clocks{5});
    CHECK(dut.fulls_sampled[0]->rises() == Clocks{6});  // it changes with the edge
    CHECK(dut.blocks[0]->at(5) == WriteBlock{0, 4, kColour});
    CHECK(dut.fulls[1]->rises() == Clocks{9});
    CHECK(dut.blocks[1]->at(9) == WriteBlock{4, 4, kColour});
    // The image's last words are a block, too. The first half is full for the second time, so its wire falls.
    CHECK(dut.fulls[0]->falls() == Clocks{11});
    CHECK(dut.blocks[0]->at(11) == WriteBlock{8, 2, kColour});
}

TEST_CASE("write buffer: a block stands still until its half is full again") {
    ClockedTestbench bench;
    BufferBench dut(bench);
    dut.bring(2, 1, 0, 8, kDepth);
    bench.run_through(12);
    CHECK(dut.blocks[0]->at(5) == WriteBlock{16, 4, kDepth});  // the second device's image
    CHECK(dut.blocks[0]->at(12) == dut.blocks[0]->at(5));
    CHECK(dut.blocks[1]->at(9) == WriteBlock{20, 4, kDepth});
}

TEST_CASE("write buffer: a block of a frame that was broken off is replaced by the next frame's first") {
    ClockedTestbench bench;
    BufferBench dut(bench);
    dut.bring(2, 0, 0, 6);   // a block, and half of one
    dut.bring(20, 0, 0, 4);  // the same block, in the second half
    dut.ask(30, true, {0, 1});
    dut.ask(31, true, {2, 3});
    bench.run_through(32);
    CHECK(dut.fulls[1]->rises() == Clocks{23});
    CHECK(dut.blocks[1]->at(23) == WriteBlock{0, 4, kColour});
    CHECK(dut.words_at(30) == Words{100, 101});
    CHECK(dut.words_at(31) == Words{102, 103});
}

TEST_CASE("write buffer: a write command's words, of the half that is written, stand in its own clock") {
    ClockedTestbench bench;
    BufferBench dut(bench);
    dut.bring(0, 0, 0, 8);
    dut.ask(12, false, {1, 2});
    dut.ask(13, true, {4, 5});  // columns in the page
    dut.ask(14, true, {7});
    bench.run_through(16);
    CHECK(dut.words_at(11).empty());
    CHECK(dut.words_at(12) == Words{101, 102});
    CHECK(dut.words_at(13) == Words{104, 105});
    CHECK(dut.words_at(14) == Words{107});
    CHECK(dut.sampled.at(14).words[1] == 105);  // a lane without a word stands still
    CHECK(dut.words_at(15).empty());
}

TEST_CASE("write buffer: no word comes out for any other command") {
    ClockedTestbench bench;
    BufferBench dut(bench);
    dut.bring(0, 0, 0, 8);
    MemoryCommand read;
    read.kind = MemoryCommand::Kind::kRead;
    read.count = 2;
    dut.core.drive(dut.command, 10, read);
    bench.run_through(12);
    CHECK(dut.words_at(11).empty());
}

TEST_CASE("write buffer: a word that stands is taken at each clock") {
    ClockedTestbench bench;
    BufferBench dut(bench);
    dut.core.drive(dut.write, 2, MemoryWrite{true, 0, 3, 103, kColour});  // a block's last one
    dut.core.drive(dut.write, 22, MemoryWrite{});
    bench.run_through(30);
    CHECK(dut.fulls[0]->rises() == Clocks{2, 6, 10, 14, 18});
    CHECK(dut.fulls[1]->rises() == Clocks{3, 7, 11, 15, 19});
}

TEST_CASE("write buffer: reset leaves it empty, whichever half was filling") {
    ClockedTestbench bench;
    BufferBench dut(bench);
    dut.bring(0, 0, 0, 4);
    bench.core.drive(bench.reset, 6, true);
    bench.core.drive(bench.reset, 8, false);
    dut.bring(10, 0, 0, 4);
    bench.run_through(16);
    CHECK(dut.fulls[0]->rises() == Clocks{3, 13});
    CHECK(dut.fulls[0]->falls() == Clocks{6});
    CHECK(dut.blocks[0]->at(7) == WriteBlock{});
    CHECK(dut.fulls[1]->rises().empty());
}

TEST_CASE("write buffer: a reset wakes a buffer that sleeps with a full half") {
    ClockedTestbench bench;
    BufferBench dut(bench);
    dut.bring(0, 0, 0, 4);
    bench.core.drive(bench.reset, 40, true);
    bench.core.drive(bench.reset, 42, false);
    bench.run_through(50);
    CHECK(dut.fulls[0]->rises() == Clocks{3});
    CHECK(dut.fulls[0]->falls() == Clocks{40});
}

}  // namespace
}  // namespace metabuffer::test::write_buffer_test
