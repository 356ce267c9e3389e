// The memory of the composer's FIFO, in its banks, against one without: whatever is asked of both, they give the same.
module memory_proof #(
    parameter int MAX_PIXELS = 16,
    parameter bit PAIR       = 0,
    localparam int ADDRESS_BITS = $clog2(MAX_PIXELS)
) (
    input logic                    clk_i,
    input logic                    reset_i,
    input logic                    whole_ring_i,  // or the half of it, from the first clock on
    input logic [3:0]              write_count_i,
    input logic [ADDRESS_BITS-1:0] write_address_i,
    input logic [511:0]            write_words_i,
    input logic                    read_i,
    input logic [ADDRESS_BITS-1:0] read_address_i,

    output logic bad,
    output logic seen_bypass,
    output logic seen_wrap
);
  logic started = 1'b0;
  logic whole_ring;
  logic [ADDRESS_BITS-1:0] last_address;
  logic [3:0] count;
  always_ff @(posedge clk_i) begin
    started <= 1'b1;
    if (!started) whole_ring <= whole_ring_i || MAX_PIXELS == 16;
  end
  assign last_address = whole_ring ? '1 : '1 >> 1;
  assign count = write_count_i > 4'd8 ? 4'd8 : write_count_i;

  logic [63:0] word, next_word, plain_word, plain_next_word;

  fifo_memory #(.MAX_PIXELS(MAX_PIXELS), .PAIR(PAIR)) banks (
      .clk_i,
      .reset_i(reset_i || !started),
      .last_address_i(last_address),
      .write_count_i(count),
      .write_address_i(write_address_i & last_address),
      .write_words_i,
      .read_i,
      .read_address_i(read_address_i & last_address),
      .word_o(word),
      .next_word_o(next_word)
  );
  plain_memory #(.MAX_PIXELS(MAX_PIXELS), .PAIR(PAIR)) plain (
      .clk_i,
      .reset_i(reset_i || !started),
      .last_address_i(last_address),
      .write_count_i(count),
      .write_address_i(write_address_i & last_address),
      .write_words_i,
      .read_i,
      .read_address_i(read_address_i & last_address),
      .word_o(plain_word),
      .next_word_o(plain_next_word)
  );

  assign bad = started && (word != plain_word || next_word != plain_next_word);
  assign seen_bypass = started && !reset_i && read_i && count != '0 && read_address_i == write_address_i && word != '0;
  assign seen_wrap = started && !reset_i && (write_address_i & last_address) == last_address && count > 4'd1;
endmodule
