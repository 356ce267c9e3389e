// The memory of a composer's FIFO, as one read port has it: a ring of words in eight banks. Each word of a beat lies in
// another bank, and so do a word and the one after it.
//
// A read gives what is written to its addresses at the same edge. The words stand until the next read.
module fifo_memory #(
    parameter  int MAX_PIXELS   = 4096,  // a power of two, 16 or more
    parameter  bit PAIR         = 1'b0,  // a read gives the word after the one that is read, too
    localparam int ADDRESS_BITS = $clog2(MAX_PIXELS)
) (
    input  logic                    clk_i,
    input  logic                    reset_i,         // synchronous, active high; what is stored stays
    input  logic [ADDRESS_BITS-1:0] last_address_i,  // of the ring
    input  logic [3:0]              write_count_i,
    input  logic [ADDRESS_BITS-1:0] write_address_i,
    input  logic [511:0]            write_words_i,
    input  logic                    read_i,
    input  logic [ADDRESS_BITS-1:0] read_address_i,
    output logic [63:0]             word_o,
    output logic [63:0]             next_word_o      // after that at word_o; 0 without PAIR
);
  localparam int BANKS = 8;
  localparam int WORDS = PAIR ? 2 : 1;

  logic [63:0] bank_word[BANKS];

  for (genvar bank = 0; bank < BANKS; bank = bank + 1) begin : gen_bank
    logic [2:0] lane;
    logic [ADDRESS_BITS-4:0] address;  // in the bank: one further for the lanes past the ring's bank 7
    assign lane = 3'(bank) - write_address_i[2:0];
    assign address = (write_address_i[ADDRESS_BITS-1:3] + (ADDRESS_BITS - 3)'(lane > ~write_address_i[2:0])) &
                     last_address_i[ADDRESS_BITS-1:3];
    logic reads;
    logic [ADDRESS_BITS-4:0] read_address;
    if (PAIR) begin : gen_pair
      logic [2:0] after;  // which word of the pair this bank has
      assign after = 3'(bank) - read_address_i[2:0];
      assign reads = read_i && after < 3'd2;
      assign read_address = (read_address_i[ADDRESS_BITS-1:3] + (ADDRESS_BITS - 3)'(after > ~read_address_i[2:0])) &
                            last_address_i[ADDRESS_BITS-1:3];
    end else begin : gen_single
      assign reads = read_i && read_address_i[2:0] == 3'(bank);
      assign read_address = read_address_i[ADDRESS_BITS-1:3];
    end
    pixel_bank #(
        .DEPTH(MAX_PIXELS / BANKS)
    ) memory (
        .clk_i,
        .write_i(!reset_i && {1'b0, lane} < write_count_i),
        .write_address_i(address),
        .write_lane_i(lane),
        .words_i(write_words_i),
        .read_i(reads),
        .read_address_i(read_address),
        .word_o(bank_word[bank])
    );
  end

  logic [63:0] words[WORDS];

  for (genvar word = 0; word < WORDS; word = word + 1) begin : gen_word
    logic [ADDRESS_BITS-1:0] distance;  // from the first word that is written
    logic [2:0] bank;
    logic bypass;
    logic [63:0] bypass_word;

    assign distance = (read_address_i + ADDRESS_BITS'(word) - write_address_i) & last_address_i;

    always_ff @(posedge clk_i) begin : read_registers
      if (reset_i) begin
        bypass <= 1'b1;
        bypass_word <= '0;
      end else if (read_i) begin
        bank <= read_address_i[2:0] + 3'(word);
        bypass <= distance < ADDRESS_BITS'(write_count_i);
        bypass_word <= write_words_i[64*distance[2:0] +: 64];
      end
    end

    assign words[word] = bypass ? bypass_word : bank_word[bank];
  end

  assign word_o = words[0];
  if (PAIR) begin : gen_next_word
    assign next_word_o = words[WORDS-1];
  end else begin : gen_no_next_word
    assign next_word_o = '0;
  end
endmodule
