// The world of the scenarios: a checkered ball and a striped tube in a wavy sea, after the figures of the paper.
//
// One world and one camera serve every image. What a render shows is chosen on the command line, so that the image of a
// renderer is exactly a rectangle of the joint view, at any resolution; scripts/render-images has the whole list.
//
//   Declare=Scene=N          sum of: 1 ball, 2 tube, 4 sea and sky; 7 is everything in one piece, the ground truth;
//                              8 buoy, 16 post, which float on the open sea and are no part of the whole
//   Declare=Open=1           the sea without foam and shade where ball and tube stand, for images that are moved
//   Declare=Distance=N       of buoy and post, in tenths of a unit from the camera's plane
//   Declare=Colours=N        of buoy and post, 0 to 3
//   Declare=GX=N, GY=N       the whole view is a grid of GX x GY pixels
//   Declare=X0, Y0, X1, Y1   the rectangle of that grid to render, Y downwards, ends exclusive (default: all of it)
//   Declare=Pass=0|1         0 colour and alpha, 1 depth
//   Declare=ZBits=16|24      steps of the depth pass: 2^ZBits - 1 from near to far
//   Declare=Layers=N         the depth range is cut into N layers, as glDepthRange does,
//   Declare=Layer=I            and this render lies in layer I; 0 is the nearest (default: one layer)
//   Declare=Beauty=1         shadows and mirror images between the objects, for a picture of the whole world alone
//
// Values given with Declare= are single precision: hand over integers, the scene divides.
//
// Without Beauty no object knows of another: none casts a shadow on another or is mirrored in one, so the depth
// composite of the single renders equals the render of all. (The sea's foam and the shade in it are painted where ball
// and tube stand, whether these are rendered or not. Mirrored is only the sky, which is the same for all.)
//
// Render without antialiasing: a pixel is one ray, and alpha is 0 or 1.
#version 3.7;
global_settings { assumed_gamma 1.0  max_trace_level 4 }

#ifndef (Scene)  #declare Scene = 7;  #end
#ifndef (Pass)   #declare Pass = 0;   #end
#ifndef (ZBits)  #declare ZBits = 16; #end
#ifndef (Layers) #declare Layers = 1; #end
#ifndef (Layer)  #declare Layer = 0;  #end
#ifndef (Beauty) #declare Beauty = 0; #end
#ifndef (Open)   #declare Open = 0;   #end
#ifndef (Distance) #declare Distance = 100; #end
#ifndef (Colours)  #declare Colours = 0;    #end
#ifndef (GX) #declare GX = 640; #end
#ifndef (GY) #declare GY = 480; #end
#ifndef (X0) #declare X0 = 0;   #end
#ifndef (Y0) #declare Y0 = 0;   #end
#ifndef (X1) #declare X1 = GX;  #end
#ifndef (Y1) #declare Y1 = GY;  #end

#declare HasBall = (bitwise_and(Scene, 1) != 0);
#declare HasTube = (bitwise_and(Scene, 2) != 0);
#declare HasSea  = (bitwise_and(Scene, 4) != 0);
#declare HasBuoy = (bitwise_and(Scene, 8) != 0);
#declare HasPost = (bitwise_and(Scene, 16) != 0);

// ---- camera -------------------------------------------------------------------------------------------------------
// An orthonormal basis (right, up, axis) with the image plane at distance 1; the rectangle is an off-axis window of it,
// so its rays are those of the same pixels of the whole view.
#declare Eye   = <0, 2.0, -10>;
#declare Axis  = vnormalize(<0, 1.32, 0> - Eye);
#declare Right = vnormalize(vcross(y, Axis));
#declare Up    = vcross(Axis, Right);
#declare H = 2*tan(radians(36)/2);                      // 36 degrees from top to bottom
#declare W = H*GX/GY;
camera {
  perspective
  location  Eye
  direction Axis + ((X0 + X1)/(2*GX) - 0.5)*W*Right + (0.5 - (Y0 + Y1)/(2*GY))*H*Up
  right     (X1 - X0)/GX*W*Right
  up        (Y1 - Y0)/GY*H*Up
}

// ---- depth pass ---------------------------------------------------------------------------------------------------
// Depth is the distance from the plane through the eye (not from the eye), in scene units from Near to Far: the
// `depth_range` of the scenarios. With a range of 0 to a power of two a single-precision float tells all steps of a
// 24-bit Z apart. What is not hit is Far. The sky, and the sea beyond, are nearer by a 16-bit step: they are to cover
// the background colour of the displays, and a tie would not.
//
// A pixel holds the number of its step, 0 to 2^ZBits - 1, in three bytes: red the high one, blue the low one.
#declare Near = 0;
#declare Far  = 64;
#declare AxisX = Axis.x;
#declare AxisY = Axis.y;
#declare AxisZ = Axis.z;
#declare Axis0 = vdot(Axis, Eye) + Near;
#declare Steps = pow(2, ZBits) - 1;
#declare Beyond = floor(Steps*65534/65535 + 0.5);       // the step of the sky
#declare FnZ = function(x, y, z) { max(0, min(1, (AxisX*x + AxisY*y + AxisZ*z - Axis0)/(Far - Near))) }
#declare FnN = function(x, y, z) { min(Beyond, floor((Layer + FnZ(x, y, z))/Layers*Steps + 0.5)) }
#declare FnHigh   = function(x, y, z) { floor(FnN(x, y, z)/65536) }
#declare FnMiddle = function(x, y, z) { floor(FnN(x, y, z)/256) - 256*FnHigh(x, y, z) }
#declare FnLow    = function(x, y, z) { FnN(x, y, z) - 256*floor(FnN(x, y, z)/256) }
// A pattern's value wraps at 1: byte/256 stays below. The map makes byte/255 of it, and thrice that for the average.
#declare C = 3*256/255;
#declare DepthTexture = texture {
  pigment {
    average pigment_map {
      [1 function { FnHigh(x, y, z)/256 }   color_map { [0 rgb 0] [1 rgb <C, 0, 0>] }]
      [1 function { FnMiddle(x, y, z)/256 } color_map { [0 rgb 0] [1 rgb <0, C, 0>] }]
      [1 function { FnLow(x, y, z)/256 }    color_map { [0 rgb 0] [1 rgb <0, 0, C>] }]
    }
  }
  finish { ambient 0 diffuse 0 emission 1 }
}

// The look of an object in this pass.
#macro Look(ColourTexture)
  #if (Pass = 0) texture { ColourTexture } #else texture { DepthTexture } #end
  #if (!Beauty) no_shadow no_reflection #end
#end

#if (Pass = 0) background { rgbt <0, 0, 0, 1> } #else background { rgb <(ZBits = 24), 1, 1> } #end

// ---- light and sky ------------------------------------------------------------------------------------------------
light_source { <-38, 42, -48> rgb <1.15, 1.08, 0.95> }
light_source { <40, 14, -30>  rgb <0.16, 0.20, 0.28> shadowless }

// A shell round the world: seen in the renders with the sea, mirrored in all. Below the horizon it turns dark, as the
// sea is.
#declare Sky = function { min(1, max(0, 0.5 + y/2)) }
#declare SkyPigment = pigment {
  function { Sky(x, y, z) }
  pigment_map {
    [0.000 rgb <0.02, 0.10, 0.16>]
    [0.420 rgb <0.10, 0.24, 0.36>]
    [0.500 rgb <0.76, 0.80, 0.80>]
    [0.520 rgb <0.56, 0.70, 0.82>]
    [0.545 wrinkles turbulence 0.55 octaves 5 omega 0.55 lambda 2.2
           scale <0.34, 0.055, 0.34> rotate y*38 translate <0.13, 0.02, 0>
           color_map { [0.36 rgb <0.26, 0.46, 0.74>] [0.60 rgb <0.88, 0.89, 0.90>] [0.85 rgb <0.97, 0.96, 0.94>] }]
    [0.640 wrinkles turbulence 0.55 octaves 5 omega 0.55 lambda 2.2
           scale <0.34, 0.055, 0.34> rotate y*38 translate <0.13, 0.02, 0>
           color_map { [0.42 rgb <0.12, 0.29, 0.62>] [0.70 rgb <0.80, 0.85, 0.90>] [0.95 rgb <0.97, 0.96, 0.94>] }]
    [0.800 rgb <0.05, 0.15, 0.42>]
  }
  scale 900
}
sphere {
  0, 900
  #if (Pass = 0)
    texture { pigment { SkyPigment } finish { ambient 0 diffuse 0 emission 1 } }
  #else
    texture { DepthTexture }
  #end
  hollow no_shadow
  #if (!HasSea) no_image #end
}

// ---- where ball and tube stand ------------------------------------------------------------------------------------
#declare BallCentre = <-1.58, 0.70, -1.3>;
#declare BallRadius = 1.08;

#declare TubeAxis   = vnormalize(<0.30, 0.85, -0.40>);
#declare TubeCentre = <-0.02, 1.25, 0.55>;               // on the tube's axis, in the middle of the view
#declare TubeOuter  = 0.98;
#declare TubeInner  = 0.80;
#declare TubeTop    = 1.75;                             // from TubeCentre along the axis
#declare TubeBottom = -2.9;

// From the tube's own frame (axis along y) into the world.
#declare TubeX = vnormalize(vcross(TubeAxis, z));
#declare TubeZ = vcross(TubeX, TubeAxis);
#declare TubePlace = transform {
  matrix <TubeX.x, TubeX.y, TubeX.z, TubeAxis.x, TubeAxis.y, TubeAxis.z, TubeZ.x, TubeZ.y, TubeZ.z,
          TubeCentre.x, TubeCentre.y, TubeCentre.z>
}

// 0 at the waterline, 1 where it is dry: wet things are darker.
#declare FnDry = function(x, y, z) { max(0.001, min(0.999, (y - 0.10)/0.22)) }

// ---- ball ---------------------------------------------------------------------------------------------------------
#declare FnBall = function(x, y, z) {
  select(sin(8*atan2(y, sqrt(x*x + z*z)))*sin(8*atan2(x, z)), 0.25, 0.75)
}
#macro BallPigment(Red, White)
  function { FnBall(x, y, z) } color_map { [0.5 rgb Red] [0.5 rgb White] }
  rotate <8, 17, -24> translate BallCentre
#end
#if (HasBall)
  sphere {
    BallCentre, BallRadius
    Look(texture {
      pigment {
        function { FnDry(x, y, z) }
        pigment_map {
          [0 BallPigment(<0.22, 0.015, 0.01>, <0.34, 0.34, 0.33>)]
          [1 BallPigment(<0.72, 0.035, 0.02>, <0.90, 0.88, 0.84>)]
        }
      }
      finish { ambient 0.10 diffuse 0.78 specular 0.55 roughness 0.012 reflection { 0.01, 0.22 } }
    })
  }
#end

// ---- tube ---------------------------------------------------------------------------------------------------------
// A stripe that winds up the tube; the fraction is taken here, since a wrapped pattern would jump below 0.
#declare FnTurn   = function(x, y, z) { 0.85*y + atan2(x, z)/(2*pi) + 16 }
#declare FnStripe = function(x, y, z) { select(FnTurn(x, y, z) - floor(FnTurn(x, y, z)) - 0.5, 0.25, 0.75) }
#macro TubePigment(Light, Dark)
  function { FnStripe(x, y, z) } color_map { [0.5 rgb Light] [0.5 rgb Dark] }
  transform { TubePlace }
#end
#if (HasTube)
  #declare TubeFinish = finish { ambient 0.10 diffuse 0.78 specular 0.35 roughness 0.03 reflection { 0.01, 0.12 } }
  #declare TubeOutside = texture {
    pigment {
      function { FnDry(x, y, z) }
      pigment_map {
        [0 TubePigment(<0.42, 0.26, 0.02>, <0.01, 0.06, 0.07>)]
        [1 TubePigment(<0.92, 0.62, 0.06>, <0.02, 0.15, 0.18>)]
      }
    }
    finish { TubeFinish }
  }
  // The inside darkens from the mouth down, which stands for the shadow that is not cast.
  #declare TubeInside = texture {
    pigment {
      function { max(0.001, min(0.999, (TubeTop - y)/1.5)) }
      color_map { [0 rgb <0.50, 0.33, 0.07>] [0.5 rgb <0.10, 0.07, 0.03>] [1 rgb <0.01, 0.01, 0.01>] }
      transform { TubePlace }
    }
    finish { ambient 0.12 diffuse 0.7 }
  }
  #declare TubeLip = texture { pigment { rgb <0.92, 0.62, 0.06> } finish { TubeFinish } }
  union {
    cylinder { TubeBottom*y, TubeTop*y, TubeOuter open transform { TubePlace } Look(TubeOutside) }
    cylinder { TubeBottom*y, TubeTop*y, TubeInner open transform { TubePlace } Look(TubeInside) }
    torus {
      (TubeOuter + TubeInner)/2, (TubeOuter - TubeInner)/2
      translate TubeTop*y transform { TubePlace } Look(TubeLip)
    }
  }
#end

// ---- buoy and post ------------------------------------------------------------------------------------------------
// A small ball and a small tube in the middle of the view. Moved sideways on the wall, an image of one stays at its
// distance and still meets the waves where it should.
#if (HasBuoy | HasPost)
  #declare FloatZ = Eye.z + (Distance/10 + Axis.y*Eye.y)/Axis.z;  // where the plane of that distance cuts the water
  #switch (Colours)
    #case (0) #declare Bright = rgb <0.90, 0.88, 0.84>; #declare Deep = rgb <0.72, 0.035, 0.02>; #break
    #case (1) #declare Bright = rgb <0.95, 0.66, 0.06>; #declare Deep = rgb <0.03, 0.10, 0.36>;  #break
    #case (2) #declare Bright = rgb <0.92, 0.90, 0.80>; #declare Deep = rgb <0.02, 0.26, 0.16>;  #break
    #else     #declare Bright = rgb <0.98, 0.36, 0.04>; #declare Deep = rgb <0.20, 0.03, 0.24>;
  #end
  #declare FloatFinish = finish { ambient 0.10 diffuse 0.78 specular 0.55 roughness 0.012 reflection { 0.01, 0.22 } }
#end
#if (HasBuoy)
  sphere {
    <0, 0.20, FloatZ>, 0.45
    Look(texture {
      pigment {
        function { FnBall(x, y, z) } color_map { [0.5 Deep] [0.5 Bright] }
        rotate <8, 17, -24> translate <0, 0.20, FloatZ>
      }
      finish { FloatFinish }
    })
  }
#end
#if (HasPost)
  #declare PostPlace = transform { rotate <12, 0, -14> translate <0, 0.20, FloatZ> }
  #declare PostOutside = texture {
    pigment {
      function { select(3.2*y + atan2(x, z)/(2*pi) + 16 - floor(3.2*y + atan2(x, z)/(2*pi) + 16) - 0.5, 0.25, 0.75) }
      color_map { [0.5 Deep] [0.5 Bright] }
      transform { PostPlace }
    }
    finish { FloatFinish }
  }
  union {
    cylinder { -0.60*y, 0.60*y, 0.27 open transform { PostPlace } Look(PostOutside) }
    cylinder {
      -0.60*y, 0.60*y, 0.21 open transform { PostPlace }
      Look(texture { pigment { Deep*0.3 } finish { ambient 0.12 diffuse 0.7 } })
    }
    torus {
      0.24, 0.03
      translate 0.60*y transform { PostPlace } Look(texture { pigment { Bright } finish { FloatFinish } })
    }
  }
#end

// ---- sea ----------------------------------------------------------------------------------------------------------
#if (HasSea)
  // Waves calm down with the distance, where a pixel holds many of them.
  #declare FnCalm = function(x, z) { 1/(1 + 0.0016*(x*x + (z + 10)*(z + 10))) }
  #declare FnWave = function(x, z) {
    FnCalm(x, z)*( 0.085*sin(1.35*x + 0.75*z + 0.35*sin(0.8*z))
                 + 0.065*sin(-0.95*x + 2.10*z + 1.0 + 0.4*sin(0.7*x))
                 + 0.040*sin(3.10*x - 1.40*z + 2.0)
                 + 0.030*sin(1.10*x + 4.30*z)
                 + 0.018*sin(-5.20*x + 2.90*z + 0.7)
                 + 0.012*sin(6.10*x + 6.70*z + 1.9) )
  }
  // Distance of a point of the sea from the skins of ball and tube: there is foam, and shade to the lee of the light.
  #declare Bx = BallCentre.x;  #declare By = BallCentre.y;  #declare Bz = BallCentre.z;
  #declare Cx = TubeCentre.x;  #declare Cy = TubeCentre.y;  #declare Cz = TubeCentre.z;
  #declare Ax = TubeAxis.x;    #declare Ay = TubeAxis.y;    #declare Az = TubeAxis.z;
  #declare FnToBall = function(x, y, z) {
    sqrt((x - Bx)*(x - Bx) + (y - By)*(y - By) + (z - Bz)*(z - Bz)) - BallRadius
  }
  #declare FnAlong  = function(x, y, z) { (x - Cx)*Ax + (y - Cy)*Ay + (z - Cz)*Az }
  #declare FnToTube = function(x, y, z) {
    sqrt(max(0, (x - Cx)*(x - Cx) + (y - Cy)*(y - Cy) + (z - Cz)*(z - Cz)
                - FnAlong(x, y, z)*FnAlong(x, y, z))) - TubeOuter
  }
  #if (Open)
    #declare FnSkin = function(x, y, z) { 100 }
  #else
    #declare FnSkin = function(x, y, z) { max(0, min(FnToBall(x, y, z), FnToTube(x, y, z))) }
  #end
  #declare FnShade = function(x, y, z) { max(0.001, min(0.999, FnSkin(x, y, z)/0.9)) }
  #declare FnFoam  = function(x, y, z) {
    max(0.001, min(0.999,
      1.15*exp(-9*FnSkin(x, y, z))*(0.75 + 0.25*sin(9*x + 5*z)*sin(7*z - 4*x + 1))
      + 0.35*exp(-2.2*FnSkin(x, y, z))*max(0, sin(26*FnSkin(x, y, z) - 2.0 + 0.8*sin(5*x + 3*z)))))
  }
  #declare SeaPigment = pigment {
    function { max(0.001, min(0.999, 0.5 + 1.9*y)) }
    color_map { [0 rgb <0.004, 0.040, 0.080>] [0.6 rgb <0.012, 0.12, 0.17>] [1 rgb <0.06, 0.30, 0.32>] }
  }
  isosurface {
    function { y - FnWave(x, z) }
    contained_by { box { <-260, -0.4, -9.5>, <260, 0.4, 420> } }
    accuracy 1e-5
    max_gradient 1.7
    Look(texture {
      pigment {
        function { FnFoam(x, y, z) }
        pigment_map {
          [0.12 function { FnShade(x, y, z) } pigment_map { [0 rgb <0.002, 0.018, 0.03>] [1 SeaPigment] }]
          [0.55 rgb <0.55, 0.66, 0.68>]
          [1.00 rgb <0.88, 0.92, 0.92>]
        }
      }
      finish {
        ambient 0.10 diffuse 0.70 specular 0.55 roughness 0.010 reflection { 0.02, 0.60 fresnel on } conserve_energy
      }
    })
    interior { ior 1.33 }
  }
#end
