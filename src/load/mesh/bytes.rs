//! Values out of binary data.

use std::io::Read;

use super::error::{Fault, MeshProblem};
use super::source::Source;

/// Bytes that are read at once.
const BLOCK: usize = 1 << 20;

/// Values from a block of bytes that is refilled when it runs out.
pub(super) struct Bytes {
    source: Source,
    big_endian: bool,
    block: Vec<u8>,
    at: usize,
    /// How many bytes of the data came before the last value.
    last: u64,
    /// How many bytes of the data came before the block.
    before: u64,
}

impl Bytes {
    /// What is left of `source`, from which so many bytes have been read.
    pub(super) fn new(source: Source, before: u64, big_endian: bool) -> Self {
        Self { source, big_endian, block: Vec::new(), at: 0, last: before, before }
    }

    /// Whether so many more bytes (at most a block) are there; reads on where needed.
    pub(super) fn remaining(&mut self, count: usize) -> Result<bool, Fault> {
        if self.block.len() - self.at < count {
            self.block.drain(..self.at);
            self.before += self.at as u64;
            self.at = 0;
            let room = (BLOCK - self.block.len()) as u64;
            (&mut self.source.reader).take(room).read_to_end(&mut self.block)?;
        }
        Ok(self.block.len() >= self.at + count)
    }

    /// The next bytes, the least significant first.
    #[inline]
    pub(super) fn next<const N: usize>(&mut self) -> Result<[u8; N], Fault> {
        let mut bytes = match self.block[self.at..].first_chunk() {
            Some(bytes) => *bytes,
            None => self.next_in_file()?,
        };
        self.last = self.before + self.at as u64;
        self.at += N;
        if self.big_endian {
            bytes.reverse();
        }
        Ok(bytes)
    }

    /// The bytes at `at`, where the block does not hold all of them.
    #[cold]
    fn next_in_file<const N: usize>(&mut self) -> Result<[u8; N], Fault> {
        self.remaining(N)?;
        let bytes = self.block[self.at..].first_chunk();
        bytes.copied().ok_or_else(|| MeshProblem::MissingValue.into())
    }

    /// Steps over so many bytes.
    pub(super) fn skip_bytes(&mut self, mut count: u64) -> Result<(), Fault> {
        while count > 0 {
            if !self.remaining(1)? {
                return Err(MeshProblem::MissingValue.into());
            }
            let step = (self.block.len() - self.at).min(usize::try_from(count).unwrap_or(BLOCK));
            self.at += step;
            count -= step as u64;
        }
        Ok(())
    }

    /// How many bytes of the data came before the last value.
    pub(super) fn last(&self) -> u64 {
        self.last
    }

    /// How many bytes of the data come before the next value.
    pub(super) fn position(&self) -> u64 {
        self.before + self.at as u64
    }

    /// How many bytes of the data were read.
    pub(super) fn end(&self) -> u64 {
        self.before + self.block.len() as u64
    }

    /// Where they come from.
    pub(super) fn source(&self) -> &Source {
        &self.source
    }
}
