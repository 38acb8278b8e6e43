# The mmsim command without an operating system. The binaries are those of the release archives for
# Linux, because they need no libraries:
#
#   .ci/release
#   mkdir -p target/docker/linux/amd64
#   tar -xzf target/archives/mmsim-*-x86_64-unknown-linux-musl.tar.gz --strip-components=1 \
#       -C target/docker/linux/amd64
#   docker build -f Dockerfile -t mmsim target/docker
#   docker run --rm -p 6574:6574 -p 6575:6575 mmsim
FROM scratch
ARG TARGETPLATFORM
LABEL org.opencontainers.image.source="https://github.com/mmsim/mmsim" \
    org.opencontainers.image.licenses="MIT OR Apache-2.0"
COPY $TARGETPLATFORM/mmsim /mmsim
COPY $TARGETPLATFORM/THIRD-PARTY-LICENSES.txt $TARGETPLATFORM/LICENSE-* /licenses/
# The user nobody.
USER 65534:65534
EXPOSE 6574 6575
ENTRYPOINT ["/mmsim"]
CMD ["--host", "0.0.0.0"]
