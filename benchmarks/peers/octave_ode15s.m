% The benchmark's work by ode15s. A template: octave_ode15s.py fills in the numbers. Equations and units are
% those of equations.py.
1;

function [df, dg] = valve(v, p1, p2, q1, q2, push1, push2)
  opening = min(1, (abs(v) - @deadband@) * @per_volt@);
  if opening < @shut_opening@
    df = -@shut_rate@ * q1;
    dg = -@shut_rate@ * q2;
  else
    drop = @resistance@ / (opening * opening);
    if v > 0
      df = push1 * (@supply@ - p1 - drop * q1 * abs(q1));
      dg = push2 * (p2 - drop * q2 * abs(q2));
    else
      df = push1 * (-p1 - drop * q1 * abs(q1));
      dg = push2 * (p2 - @supply@ - drop * q2 * abs(q2));
    end
  end
end

function d = rates(t, y, w)
  u1 = y(2); p1 = y(3); r1 = y(4); f1 = y(5); g1 = y(6);
  q2 = y(7); u2 = y(8); p2 = y(9); r2 = y(10); f2 = y(11); g2 = y(12);
  q3 = y(13); u3 = y(14); p3 = y(15); r3 = y(16); f3 = y(17); g3 = y(18);
  c2 = cos(q2); s2 = sin(q2); c3 = cos(q3); s3 = sin(q3);
  c23 = c2 * c3 - s2 * s3; s23 = s2 * c3 + c2 * s3;
  x2 = @x_2@ * c2 - @y_2@ * s2; h2 = @x_2@ * s2 + @y_2@ * c2;
  x3 = @x_3@ * c23 - @y_3@ * s23; h3 = @x_3@ * s23 + @y_3@ * c23;
  far = @l_2@ * c2 + x3; high = @l_2@ * s2 + h3;
  m2r2 = @m_2@ * (@l_1@ + x2); m3r3 = @m_3@ * (@l_1@ + far);
  m11 = m3r3 * (@l_1@ + far) + m2r2 * (@l_1@ + x2) + @base@ + @boom_yy@ * c2 * c2 + @stick_yy@ * c23 * c23;
  n3 = m3r3 * h3 + @stick_yy@ * c23 * s23;
  n2 = m3r3 * high + m2r2 * h2 + @boom_yy@ * c2 * s2 + @stick_yy@ * c23 * s23;
  turn = @turn_x@ * c3 - @turn_y@ * s3; bend = @turn_x@ * s3 + @turn_y@ * c3;
  m22 = @boom@ + 2 * turn; m23 = @stick@ + turn;
  weight3 = @gravity@ * @m_3@ * x3;
  weight2 = weight3 + @gravity@ * (@m_3@ * @l_2@ * c2 + @m_2@ * x2);
  arm2 = @product_1@ * sin(q2 + @offset_1@) / sqrt(@squares_1@ - 2 * @product_1@ * cos(q2 + @offset_1@));
  arm3 = @product_2@ * sin(q3 + @offset_2@) / sqrt(@squares_2@ - 2 * @product_2@ * cos(q3 + @offset_2@));
  w2 = arm2 * u2; w3 = arm3 * u3;
  t2 = arm2 * (@force_11@ * p2 - @force_12@ * r2 - (@damping_1@ + @drag_1@ * abs(w2)) * w2);
  t3 = arm3 * (@force_21@ * p3 - @force_22@ * r3 - (@damping_2@ + @drag_2@ * abs(w3)) * w3);
  a1 = (@torque_u@ * u1 + @torque_1@ * p1 + @torque_2@ * r1 + 2 * (n2 * u2 + n3 * u3) * u1) / m11;
  b2 = t2 - n2 * u1 * u1 + bend * (2 * u2 + u3) * u3 - weight2;
  b3 = t3 - n3 * u1 * u1 - bend * u2 * u2 - weight3;
  scale = 1 / (m22 * @stick@ - m23 * m23);
  [df1, dg1] = valve(w(1) + w(2) * sin(w(3) * t + w(4)), p1, r1, f1, g1, @push_01@, @push_02@);
  [df2, dg2] = valve(w(5) + w(6) * sin(w(7) * t + w(8)), p2, r2, f2, g2, @push_11@, @push_12@);
  [df3, dg3] = valve(w(9) + w(10) * sin(w(11) * t + w(12)), p3, r3, f3, g3, @push_21@, @push_22@);
  d = [u1; a1;
       @yield_01@ * (f1 - @inlet_u@ * u1 - @inlet_1@ * p1 - @inlet_2@ * r1);
       @yield_02@ * (@outlet_u@ * u1 + @outlet_1@ * p1 + @outlet_2@ * r1 - g1); df1; dg1;
       u2; (@stick@ * b2 - m23 * b3) * scale;
       @yield_11@ * (f2 - @area_11@ * w2); @yield_12@ * (@area_12@ * w2 - g2); df2; dg2;
       u3; (m22 * b3 - m23 * b2) * scale;
       @yield_21@ * (f3 - @area_21@ * w3); @yield_22@ * (@area_22@ * w3 - g3); df3; dg3];
end

load work.mat
states = zeros(ends(end, 2) + 1, 18);
states(1, :) = start;
options = odeset("RelTol", tolerance, "AbsTol", tolerance);
began = cputime();
for s = 1:rows(waves)
  w = waves(s, :); first = ends(s, 1); last = ends(s, 2);
  y = states(first + 1, :)';
  voltage = w([1 5 9]) + w([2 6 10]) .* sin(w([3 7 11]) * first * @sample@ + w([4 8 12]));
  shut = find((abs(voltage) - @deadband@) * @per_volt@ < @shut_opening@);
  y([6 * shut - 1, 6 * shut]) = 0;
  times = (first:last) * @sample@;
  [~, result] = ode15s(@(t, y) rates(t, y, w), times, y, options);
  if numel(times) == 2  % then every step of the solver comes back
    result = result([1 end], :);
  end
  states(first + 2:last + 1, :) = result(2:end, :);
end
cpu = cputime() - began;
save -mat7-binary result.mat states cpu
