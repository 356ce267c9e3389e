#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "rtl/block.h"
#include "rtl/register.h"
#include "rtl/signals.h"

namespace metabuffer::rtl {

/// Collects the link's writes into blocks, for a frame memory whose data pins link and bus share (`memory.ports:
/// shared`; sections 4 and 5.2 of the paper). It has two halves of write_block_words words: one fills in DVI input
/// clocks while bus_port writes the other one to the memory in core clocks.
///
/// A half is full with the last word of an aligned block, or of the image. Then its full_o changes and crosses to the
/// core clock through two registers of the receiver, and block_o says where its words belong. Both stay until the other
/// half is full too and this one fills again. The half has been written by then: check_write_blocks refuses a scenario
/// in which it might not be, so nothing is raised here. A block that begins again, because its frame was broken off,
/// replaces what was there.
///
/// In core clocks it puts out the words that a write command names, of the half that drain_i names, in the same clock.
class WriteBuffer final : public Block {
  public:
    static constexpr std::size_t kHalves = 2;

    In<bool> clk_i{"clk_i"};      ///< DVI input clock
    In<bool> reset_i{"reset_i"};  ///< synchronous, active high
    In<MemoryWrite> write_i{"write_i"};
    PinVector<Out<bool>> full_o{"full_o", kHalves};  ///< change with each block
    PinVector<Out<WriteBlock>> block_o{"block_o", kHalves};
    In<MemoryCommand> command_i{"command_i"};  ///< core clock
    In<bool> drain_i{"drain_i"};               ///< core clock: the half that is written
    Out<MemoryData> data_o{"data_o"};

    /// words: pixels of one image.
    WriteBuffer(const sc_core::sc_module_name& name, const MemoryConfig& config, std::int64_t words);
    SC_HAS_PROCESS(WriteBuffer);

    void trace(sc_core::sc_trace_file* file) const override;

  private:
    struct Half {
        explicit Half(RegisterSet& set, const std::string& name)
            : full(set, name + "_full"), block(set, name + "_block") {}
        Register<bool> full;
        Register<WriteBlock> block;
        std::vector<std::uint64_t> words;
    };

    void link_edge();
    void reset();
    void take(const MemoryWrite& write);
    void put_out();

    std::uint32_t block_words_;
    std::int64_t image_words_;
    std::int64_t device_words_;
    int words_per_cycle_;

    RegisterSet registers_;
    Register<bool> filling_{registers_, "filling"};  ///< the half that the link fills
    std::array<std::unique_ptr<Half>, kHalves> halves_;
    MemoryData data_;
    Clocked clocked_{*this, clk_i, reset_i, registers_, &WriteBuffer::link_edge, &WriteBuffer::reset};
};

}  // namespace metabuffer::rtl
