// The composer's memory without its banks: what fifo_memory is proved to be, for machines that are smaller than eight
// banks.
module plain_memory #(
    parameter  int MAX_PIXELS   = 4,
    parameter  bit PAIR         = 1'b0,
    localparam int ADDRESS_BITS = $clog2(MAX_PIXELS)
) (
    input  logic                    clk_i,
    input  logic                    reset_i,
    input  logic [ADDRESS_BITS-1:0] last_address_i,
    input  logic [3:0]              write_count_i,
    input  logic [ADDRESS_BITS-1:0] write_address_i,
    input  logic [511:0]            write_words_i,
    input  logic                    read_i,
    input  logic [ADDRESS_BITS-1:0] read_address_i,
    output logic [63:0]             word_o,
    output logic [63:0]             next_word_o
);
  logic [63:0] storage[MAX_PIXELS], storage_next[MAX_PIXELS];

  always_comb begin
    for (int address = 0; address < MAX_PIXELS; address = address + 1) begin
      storage_next[address] = storage[address];
      for (int word = 0; word < 8; word = word + 1) begin
        if (!reset_i && 4'(word) < write_count_i &&
            ((write_address_i + ADDRESS_BITS'(word)) & last_address_i) == ADDRESS_BITS'(address)) begin
          storage_next[address] = write_words_i[64*word +: 64];
        end
      end
    end
  end

  for (genvar address = 0; address < MAX_PIXELS; address = address + 1) begin : gen_word
    always_ff @(posedge clk_i) storage[address] <= storage_next[address];
  end

  always_ff @(posedge clk_i) begin
    if (reset_i) begin
      word_o <= '0;
      next_word_o <= '0;
    end else if (read_i) begin
      word_o <= storage_next[read_address_i];
      next_word_o <= PAIR ? storage_next[(read_address_i + ADDRESS_BITS'(1)) & last_address_i] : '0;
    end
  end
endmodule
