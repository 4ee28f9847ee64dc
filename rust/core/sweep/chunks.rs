//! Where results go, and the chunks of cells into which a job is cut.

use super::job::Job;
use super::simulated::SIMULATED_CHUNK;
use crate::cells::columns::PADDING;

/// Where a result goes.
pub enum Buffer<'a> {
    F64(&'a mut [f64]),
    F32(&'a mut [f32]),
    /// Status codes of the same cells.
    Status(&'a mut [u8]),
}

impl<'a> Buffer<'a> {
    pub(super) fn len(&self) -> usize {
        match self {
            Buffer::F64(to) => to.len(),
            Buffer::F32(to) => to.len(),
            Buffer::Status(to) => to.len(),
        }
    }

    fn split(self, at: usize) -> (Buffer<'a>, Buffer<'a>) {
        macro_rules! halves {
            ($kind:path, $to:ident) => {{
                let (a, b) = $to.split_at_mut(at);
                ($kind(a), $kind(b))
            }};
        }
        match self {
            Buffer::F64(to) => halves!(Buffer::F64, to),
            Buffer::F32(to) => halves!(Buffer::F32, to),
            Buffer::Status(to) => halves!(Buffer::Status, to),
        }
    }
}

/// A stretch of cells, the unit of work.
pub struct Chunk<'a> {
    pub start: usize,
    pub len: usize,
    /// With the number of its request.
    pub buffers: Vec<(usize, Buffer<'a>)>,
}

/// Cuts a job into chunks of at most `chunk` cells.
pub fn cut<'a>(job: &Job, buffers: Vec<(usize, Buffer<'a>)>, chunk: usize) -> Vec<Chunk<'a>> {
    // A reduction does the work of all rivals per cell: smaller chunks keep all
    // threads busy to the end.
    let chunk = if job.simulates() { chunk.min(SIMULATED_CHUNK) } else { chunk };
    let cells = (chunk / job.rival_count().max(1)).max(PADDING).min(chunk.max(1));
    let mut chunks = Vec::with_capacity(job.cells().div_ceil(cells));
    let mut rest = buffers;
    let mut start = 0;
    while start < job.cells() {
        let len = cells.min(job.cells() - start);
        let (mut now, mut later) = (Vec::new(), Vec::new());
        for (request, buffer) in rest {
            let (a, b) = buffer.split(len);
            now.push((request, a));
            later.push((request, b));
        }
        chunks.push(Chunk { start, len, buffers: now });
        rest = later;
        start += len;
    }
    chunks
}
