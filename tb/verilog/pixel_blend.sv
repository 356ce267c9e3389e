// The local pixel of a raster pixel where a composer smooths: colour and alpha of up to four source pixels, mixed, and
// Z of its own one. See blend() in model/datapath/smoothing.h.
module pixel_blend (
    input  logic [63:0] own_i,
    input  logic [63:0] beside_i,
    input  logic [63:0] across_i,
    input  logic [63:0] diagonal_i,
    input  logic [6:0]  weight_x_i,   // of beside and diagonal, of 256
    input  logic [6:0]  weight_y_i,   // of across and diagonal
    input  logic [23:0] far_z_i,      // Z of the far plane
    input  logic        alpha_key_i,  // alpha 0 hides a pixel
    output logic [63:0] pixel_o
);
  // A neighbour that a viewer does not see counts as the own pixel.
  function automatic logic [31:0] seen_or_own(input logic [55:0] neighbour, input logic [31:0] own,
                                              input logic [23:0] far_z,
                                              input logic alpha_key);
    seen_or_own = neighbour[55:32] == far_z || (alpha_key && neighbour[31:24] == '0) ? own : neighbour[31:0];
  endfunction

  logic [31:0] own, beside, across, diagonal, mixed;
  assign own = own_i[31:0];
  assign beside = seen_or_own(beside_i[55:0], own, far_z_i, alpha_key_i);
  assign across = seen_or_own(across_i[55:0], own, far_z_i, alpha_key_i);
  assign diagonal = seen_or_own(diagonal_i[55:0], own, far_z_i, alpha_key_i);

  // Two steps between pixels, one along each axis, as one sum: own + x (beside - own) + y (across - own) + x y (own -
  // beside - across + diagonal), of 65536.
  logic [13:0] weight_xy;
  assign weight_xy = {7'd0, weight_x_i} * {7'd0, weight_y_i};

  for (genvar channel = 0; channel < 4; channel = channel + 1) begin : gen_channel
    logic signed [10:0] own_value, beside_value, across_value, diagonal_value;
    logic signed [10:0] to_beside, to_across, to_diagonal;
    logic signed [25:0] sum;
    assign own_value = {3'd0, own[8*channel+:8]};
    assign beside_value = {3'd0, beside[8*channel+:8]};
    assign across_value = {3'd0, across[8*channel+:8]};
    assign diagonal_value = {3'd0, diagonal[8*channel+:8]};
    assign to_beside = beside_value - own_value;
    assign to_across = across_value - own_value;
    assign to_diagonal = own_value - beside_value - across_value + diagonal_value;
    assign sum = $signed({2'd0, own[8*channel+:8], 16'h8000}) + to_beside * $signed({1'b0, weight_x_i, 8'd0}) +
                 to_across * $signed({1'b0, weight_y_i, 8'd0}) + to_diagonal * $signed({1'b0, weight_xy});
    assign mixed[8*channel+:8] = sum[23:16];
    logic unused_bits;
    assign unused_bits = ^{sum[25:24], sum[15:0]};
  end

  // A pixel that the key hides stays hidden.
  assign pixel_o = {8'd0, own_i[55:32], alpha_key_i && own[31:24] == '0 ? own : mixed};

  logic unused;
  assign unused = ^{own_i[63:56], beside_i[63:56], across_i[63:56], diagonal_i[63:56]};
endmodule
