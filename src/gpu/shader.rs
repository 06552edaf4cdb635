//! Compute shaders, put together from an explicit list of WGSL parts.

use super::device::Gpu;

/// The WGSL module made of `parts`, in their order.
pub fn join(parts: &[&str]) -> String {
    parts.join("\n")
}

/// `source` with each loop below a line `// unroll` written out, if it has at most `most` rounds. Its
/// counter is a constant in each copy, and so is all that follows from it, which no compiler of shaders can
/// be trusted to find out. Bounds are sums of numbers and names in `constants`:
///
/// ```wgsl
/// // unroll
/// for (var i = 0u; i < SPHERES; i++) {
///     meet(spheres[i]);
/// }
/// ```
pub fn unroll(source: &str, constants: &[(&str, usize)], most: usize) -> String {
    let bound = |sum: &str| {
        sum.split('+').try_fold(0, |sum, term| {
            let term = term.trim();
            let named = constants.iter().find(|(name, _)| *name == term).map(|(_, value)| *value);
            named.or_else(|| term.strip_suffix('u')?.parse().ok()).map(|value| sum + value)
        })
    };
    let range = |header: &str| {
        let (start, rest) = header.trim().strip_prefix("for (var i = ")?.split_once("; i < ")?;
        Some(bound(start)?..bound(rest.strip_suffix("; i++) {")?)?)
    };
    let mut unrolled = String::new();
    let mut lines = source.lines();
    while let Some(line) = lines.next() {
        let header = if line.trim() == "// unroll" { lines.next() } else { None };
        let Some(rounds) = header.and_then(range).filter(|range| range.len() <= most) else {
            unrolled.extend([line, "\n"]);
            unrolled.extend(header.into_iter().flat_map(|header| [header, "\n"]));
            continue;
        };
        let end = line.replace("// unroll", "}");
        let body: Vec<&str> = lines.by_ref().take_while(|line| *line != end).collect();
        for i in rounds {
            unrolled.push_str(&format!("{{ const i = {i}u;\n{}\n}}\n", body.join("\n")));
        }
    }
    unrolled
}

/// The compute pipeline of the entry point `entry` of the module with this source.
pub fn compute_pipeline(gpu: &Gpu, source: String, entry: &str) -> wgpu::ComputePipeline {
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(entry),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    });
    gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(entry),
        layout: None,
        module: &module,
        entry_point: Some(entry),
        compilation_options: Default::default(),
        cache: None,
    })
}

/// Resources at the bindings of group 0 of `pipeline`.
pub fn bind_group<'a>(
    gpu: &Gpu,
    pipeline: &wgpu::ComputePipeline,
    resources: impl IntoIterator<Item = (u32, wgpu::BindingResource<'a>)>,
) -> wgpu::BindGroup {
    let entry = |(binding, resource)| wgpu::BindGroupEntry { binding, resource };
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &resources.into_iter().map(entry).collect::<Vec<_>>(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loops_are_written_out_up_to_a_number_of_rounds() {
        let source = "\
fn f() {
    // unroll
    for (var i = A; i < A + 2u; i++) {
        if i == 1u {
            g(i);
        }
    }
    // unroll
    for (var i = 0u; i < MANY; i++) {
        h(i);
    }
}
";
        let unrolled = unroll(source, &[("A", 3), ("MANY", 9)], 4);
        let body = "        if i == 1u {\n            g(i);\n        }";
        let copies = [3, 4].map(|i| format!("{{ const i = {i}u;\n{body}\n}}\n")).concat();
        let (before, after) =
            (&source[..9], &source[source.find("    // unroll\n    for (var i = 0").unwrap()..]);
        assert_eq!(unrolled, format!("{before}{copies}{after}"));
        assert_eq!(unroll(source, &[("A", 0), ("MANY", 0)], 0), {
            let kept = &source[..source.find("    // unroll\n    for (var i = 0").unwrap()];
            format!("{kept}}}\n")
        });
    }
}
