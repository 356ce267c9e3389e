// A composer's local memory: a ring of pixels with a write port of a beat and a read port of a pixel, and a count of
// what it holds. The composer gives the addresses and says what need not be held any more; see
// model/rtl/composer_fifo.h, whose pins these are.
//
// What the ports ask for before a clock's edge is done at the edge. A read gives the word that is written to its
// address at the same edge. Each word of a beat lies in another bank, so the number of the ring's addresses is a power
// of two, 16 or more.
//
// A composer that smooths reads two source rows at once, and of each two words next to each other.
module composer_fifo #(
    parameter  int MAX_PIXELS   = 4096,  // a power of two, 16 or more
    parameter  int WINDOW_ROWS  = 1,     // source rows in the composer's window: 1, or 2 to smooth
    localparam int ADDRESS_BITS = $clog2(MAX_PIXELS),
    localparam int COUNT_BITS   = ADDRESS_BITS + 1
) (
    input logic clk_i,
    input logic reset_i,  // synchronous, active high; what is stored stays

    // Configuration: constant while reset is low.
    input logic [COUNT_BITS-1:0]   capacity_i,      // pixels that may be held, 1..last_address_i + 1
    input logic [ADDRESS_BITS-1:0] last_address_i,  // of the ring: a power of two less one, 15..MAX_PIXELS - 1

    input logic [3:0]              write_count_i,    // pixels of the beat, 0..8
    input logic [ADDRESS_BITS-1:0] write_address_i,  // of the first
    input logic [511:0]            write_words_i,    // word 0 lowest
    input logic                    read_i,
    input logic [ADDRESS_BITS-1:0] read_address_i,
    input logic [COUNT_BITS-1:0]   release_oldest_i,  // pixels that have had their last use
    input logic [COUNT_BITS-1:0]   release_newest_i,  // of a frame that is abandoned

    output logic [63:0]           word_o,  // stands until the next read

    // The second read port, and the word after each that is read: 0 with a window of one row.
    output logic [63:0]             next_word_o,
    input  logic                    row_read_i,
    input  logic [ADDRESS_BITS-1:0] row_read_address_i,
    output logic [63:0]             row_word_o,
    output logic [63:0]             row_next_word_o,

    output logic [COUNT_BITS-1:0] level_o,
    output logic [COUNT_BITS-1:0] free_o,
    output logic [1:0]            error_o  // what happened at the edge just past, see ERROR_...
);
  localparam logic [1:0] ERROR_NONE = 2'd0;
  localparam logic [1:0] ERROR_FULL = 2'd1;     // more pixels than were free
  localparam logic [1:0] ERROR_EMPTY = 2'd2;    // a release of more than it held, what came with it included
  localparam logic [1:0] ERROR_ADDRESS = 2'd3;  // an address that the ring does not have

  // ---- memory ----

  localparam bit PAIR = WINDOW_ROWS > 1;

  fifo_memory #(
      .MAX_PIXELS(MAX_PIXELS),
      .PAIR(PAIR)
  ) memory (
      .clk_i,
      .reset_i,
      .last_address_i,
      .write_count_i,
      .write_address_i,
      .write_words_i,
      .read_i,
      .read_address_i,
      .word_o,
      .next_word_o
  );

  logic row_beyond;  // the second port reads at an address that the ring does not have

  // A block RAM has one read port, so the second port has a copy of the memory.
  if (WINDOW_ROWS > 1) begin : gen_second_row
    fifo_memory #(
        .MAX_PIXELS(MAX_PIXELS),
        .PAIR(PAIR)
    ) memory (
        .clk_i,
        .reset_i,
        .last_address_i,
        .write_count_i,
        .write_address_i,
        .write_words_i,
        .read_i(row_read_i),
        .read_address_i(row_read_address_i),
        .word_o(row_word_o),
        .next_word_o(row_next_word_o)
    );
    assign row_beyond = row_read_i && row_read_address_i > last_address_i;
  end else begin : gen_no_second_row
    assign row_word_o = '0;
    assign row_next_word_o = '0;
    assign row_beyond = 1'b0;
    logic unused_row;
    assign unused_row = ^{row_read_i, row_read_address_i};
  end

  // ---- count ----

  logic signed [COUNT_BITS+1:0] level_next, free_next;
  logic empties, overflows, beyond;

  always_comb begin : account
    level_next = $signed({2'd0, level_o}) + $signed((COUNT_BITS + 2)'(write_count_i)) -
                 $signed({2'd0, release_oldest_i}) - $signed({2'd0, release_newest_i});
    free_next = $signed({2'd0, capacity_i}) - $signed({2'd0, level_o}) - $signed((COUNT_BITS + 2)'(write_count_i)) +
                $signed({2'd0, release_oldest_i}) + $signed({2'd0, release_newest_i});
    empties = level_next < 0;
    overflows = free_next < 0;
    beyond = (write_count_i != '0 && write_address_i > last_address_i) || (read_i && read_address_i > last_address_i) ||
             row_beyond;
  end

  assign free_o = capacity_i - level_o;

  always_ff @(posedge clk_i) begin : count_registers
    if (reset_i) begin
      level_o <= '0;
      error_o <= ERROR_NONE;
    end else begin
      if (!empties && !overflows) level_o <= level_next[COUNT_BITS-1:0];
      if (empties) error_o <= ERROR_EMPTY;
      else if (overflows) error_o <= ERROR_FULL;
      else error_o <= beyond ? ERROR_ADDRESS : ERROR_NONE;
    end
  end
endmodule
