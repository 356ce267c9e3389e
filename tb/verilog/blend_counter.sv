// The weight of one axis of the smoothing, counted from raster pixel to raster pixel: BlendCounter of
// model/datapath/smoothing.h. Raster pixel `phase` of a source pixel's block of `multiple` lies |2 phase + 1 -
// multiple| halves of a raster pixel from the block's centre. The weight of its neighbour is that distance, times 128,
// by the multiple. The first one and the step to the next are found by a reciprocal; every other one is a step more or
// less.
module blend_counter (
    input  logic        clk_i,
    input  logic [7:0]  multiple_i,     // 2..255; constant while it counts
    input  logic [22:0] reciprocal_i,   // of it
    input  logic        start_i,        // at start_phase_i
    input  logic [7:0]  start_phase_i,
    input  logic        step_i,         // to the next raster pixel
    input  logic [7:0]  phase_i,        // of that one
    output logic [6:0]  weight_o        // of the neighbour, of 256
);
  // ---- the first weight ----

  logic [8:0] start_position;  // 2 phase + 1
  logic [7:0] start_distance, start_weight, start_remainder;
  logic [30:0] start_product;
  assign start_position = {start_phase_i, 1'b1};
  assign start_distance = start_position < {1'b0, multiple_i} ? 8'({1'b0, multiple_i} - start_position)
                                                              : 8'(start_position - {1'b0, multiple_i});
  assign start_product = {23'd0, start_distance} * {8'd0, reciprocal_i};
  assign start_weight = {1'b0, start_product[22:16]};
  assign start_remainder = {start_distance[0], 7'd0} - start_weight * multiple_i;  // less than the multiple

  // ---- a step: twice a half of a raster pixel ----

  logic [7:0] weight, remainder, weight_step, remainder_step;
  logic [8:0] position, remainder_up, remainder_down;
  logic towards, away;
  assign weight_step = reciprocal_i[22:15];
  assign remainder_step = 8'd0 - weight_step * multiple_i;
  assign position = {phase_i, 1'b1};
  // The first raster pixel of a block is as far from its centre as the last one of the block before. From one half of
  // an even block to the other, the distance stays as well.
  assign towards = phase_i != '0 && position <= {1'b0, multiple_i};
  assign away = phase_i != '0 && position >= {1'b0, multiple_i} + 9'd2;
  assign remainder_up = {1'b0, remainder} + {1'b0, remainder_step};
  assign remainder_down = {1'b0, remainder} - {1'b0, remainder_step};

  always_ff @(posedge clk_i) begin
    if (start_i) begin
      weight <= start_weight;
      remainder <= start_remainder;
    end else if (step_i && towards) begin
      weight <= weight - weight_step - {7'd0, remainder_down[8]};
      remainder <= remainder_down[8] ? remainder_down[7:0] + multiple_i : remainder_down[7:0];
    end else if (step_i && away) begin
      weight <= weight + weight_step + {7'd0, remainder_up >= {1'b0, multiple_i}};
      remainder <= remainder_up >= {1'b0, multiple_i} ? remainder_up[7:0] - multiple_i : remainder_up[7:0];
    end
  end

  assign weight_o = weight[6:0];

  // The product's fraction, and a bit that is 0 in every weight.
  logic unused;
  assign unused = ^{start_product[30:23], start_product[15:0], weight[7]};
endmodule
